// Behind a one-time link: what is asked, and by whom.  The secret is shown to the studio only by this script.
import { $, say } from "./events.js";

async function look() {
  const token = location.hash.slice(1);
  const answer = await fetch("/check/look", { method: "POST", body: new URLSearchParams({ token }) }).catch(() => null);
  const asked = answer ? await answer.json().catch(() => null) : null;
  $("who").hidden = !answer?.ok;
  if (!answer?.ok) {
    say(asked?.text ?? "The studio cannot be reached; try again.");
    return;
  }
  $("asks").textContent = asked.asks;
  $("name").textContent = asked.name;
  $("about").hidden = !asked.film;
  $("film").textContent = asked.film?.name ?? "";
  $("digest").textContent = asked.film?.sha256.slice(0, 12) ?? "";
  $("pictures").hidden = !asked.pictures;
}

// Another link that is pasted into the address of this page loads nothing anew.
addEventListener("hashchange", () => location.reload());
new MutationObserver(() => { $("thanks").hidden = $("result").hidden; }).observe($("result"), { attributes: true });
addEventListener("checkfailed", look);
look();
