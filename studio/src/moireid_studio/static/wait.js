// The page of a film that is being judged: shows its progress, then the verdict: by reloading, or in the page of the form.
"use strict";
(() => {
  const next = globalThis.moireid?.next ?? (() => location.reload());
  const job = document.getElementById("job").dataset.job;
  const bar = document.getElementById("bar");
  const state = document.getElementById("state");
  const words = { receiving: "Receiving", waiting: "Waiting for its turn", working: "Reading the film" };
  const events = new EventSource(`/api/jobs/${job}/events`);

  events.addEventListener("progress", (event) => {
    const now = JSON.parse(event.data);
    const all = now.expected && now.read >= now.expected;
    if (now.expected) { bar.max = now.expected; bar.value = now.read; }
    const frames = now.read ? `: ${now.read}${now.expected ? ` of ${now.expected}` : ""} frames` : "";
    state.textContent = (all ? "Judging" : words[now.state]) + frames;
  });
  events.addEventListener("end", () => { events.close(); next(); });
  // The browser connects again by itself; where it gives up, the page reloads.
  events.addEventListener("error", () => { if (events.readyState === EventSource.CLOSED) setTimeout(next, 2000); });
})();
