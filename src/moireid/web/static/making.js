// Follows a job by server-sent events, told as a bar and in words, and loads the page again at its end.

const card = document.querySelector("[data-job]");
const bar = card.querySelector("[data-progress]"), status = card.querySelector("[data-status]");
const events = new EventSource(`/api/badges/jobs/${card.dataset.job}/events`);

events.addEventListener("progress", (event) => {
  const { state, read, expected } = JSON.parse(event.data);
  if (expected) {
    bar.max = expected;
    bar.value = read;
  }
  const words = state === "waiting" ? "It waits for others." : expected ? `${read} of ${expected}` : "At work.";
  // Told once for each change, as a reader of the screen speaks every one.
  if (status.textContent !== words) status.textContent = words;
});
events.addEventListener("end", () => { events.close(); location.reload(); });
// The browser asks again by itself; where it cannot, the page does.
events.addEventListener("error", () => { if (events.readyState === EventSource.CLOSED) setTimeout(() => location.reload(), 2000); });
