// The asker's pages of one-time links: copies a link, and shows what became of it without being asked.
const address = document.getElementById("address");
document.getElementById("copy")?.addEventListener("click", async () => {
  address.select();
  const done = await navigator.clipboard?.writeText(address.value).then(() => true, () => false);
  document.getElementById("copied").textContent = done ? "Copied." : "Press Ctrl-C to copy it.";
});

setInterval(async () => {
  const old = document.querySelector("[data-renew]");
  if (!old || document.hidden) return;
  const answer = await fetch(location.href).catch(() => null);
  if (!answer?.ok) return;
  const came = new DOMParser().parseFromString(await answer.text(), "text/html");
  const now = came.getElementById(old.id);
  if (now && now.outerHTML !== old.outerHTML) {
    document.title = came.title;
    old.replaceWith(document.adoptNode(now));
  }
}, 2000);
