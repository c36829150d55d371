// Suggests whose badge is meant while someone types: a name, and where several people have it the id, if this visitor may
// know it.  The fields also work without this.
"use strict";

/** What is typed for each of these badges: a value, and a label where the value says no name. */
function claimsOf(badges) {
  const alone = (name) => badges.filter((one) => one.name === name).length === 1;
  return badges.map(({ id, name, line }) =>
    id && !alone(name) ? { value: id, label: line ? `${name}, ${line}` : name } : { value: name });
}

for (const field of document.querySelectorAll("input[data-claims]")) {
  const list = Object.assign(document.createElement("datalist"), { id: `${field.id}-claims` });
  field.after(list);
  field.setAttribute("list", list.id);
  let asked = 0;
  field.addEventListener("input", async () => {
    const mine = ++asked;
    const name = field.value.trim();
    const answer = await fetch(`/api/registry?limit=20&search=${encodeURIComponent(name)}`).catch(() => null);
    if (!answer?.ok || mine !== asked) return;
    const seen = new Map(claimsOf((await answer.json()).badges).map((claim) => [claim.value, claim]));
    list.replaceChildren(...[...seen.values()].map((claim) => Object.assign(document.createElement("option"), claim)));
  });
}
