// Follows a job and shows its end: what the server says by server-sent events, told as a bar and in words.

const card = document.querySelector("[data-job]");
const bar = card.querySelector("[data-progress]"), status = card.querySelector("[data-status]");
const events = new EventSource(`${card.dataset.job}/events`);

events.addEventListener("message", (event) => {
  const { state, done, of } = JSON.parse(event.data);
  if (state === "done" || state === "failed") {
    events.close();
    location.reload();
    return;
  }
  if (of) {
    bar.max = of;
    bar.value = done;
  }
  const words = state === "waiting" ? "It waits for others." : of ? `${done} of ${of}` : "At work.";
  // Told once for each change, as a reader of the screen speaks every one.
  if (status.textContent !== words) status.textContent = words;
});
