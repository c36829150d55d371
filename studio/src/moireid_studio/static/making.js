// Follows a job by server-sent events, shows its progress as a bar and in words, and reloads the page at its end.

const card = document.querySelector("[data-job]");
const bar = card.querySelector("[data-progress]"), status = card.querySelector("[data-status]");
const events = new EventSource(`/api/badges/jobs/${card.dataset.job}/events`);

events.addEventListener("progress", (event) => {
  const { state, read, expected } = JSON.parse(event.data);
  if (expected) {
    bar.max = expected;
    bar.value = read;
  }
  const words = state === "waiting" ? "Waiting for other jobs." : expected ? `${read} of ${expected}` : "Working.";
  // Written only when it changes, because a screen reader speaks each new text.
  if (status.textContent !== words) status.textContent = words;
});
events.addEventListener("end", () => { events.close(); location.reload(); });
// The browser connects again by itself; where it gives up, the page reloads.
events.addEventListener("error", () => { if (events.readyState === EventSource.CLOSED) setTimeout(() => location.reload(), 2000); });
