// Several films at once: each is sent by itself, a few at a time, and its verdict appears in a list.
"use strict";
const AT_A_TIME = 3, WAIT_MS = 1500, BUSY_MS = 10000;
const SAID = { accept: ["pass", "✓ accepted"], reject: ["fail", "✗ rejected"], inconclusive: ["undecided", "? inconclusive"],
  found: ["pass", "✓ holder found"], nobody: ["fail", "✗ held by no one"] };
const wait = (ms) => new Promise((done) => { setTimeout(done, ms); });

async function judgeAll(form, films, refused) {
  const rows = document.getElementById("batch-rows");
  rows.replaceChildren();
  document.getElementById("batch").hidden = false;
  const work = films.map((film) => {
    const row = document.createElement("tr"), name = document.createElement("td"), said = document.createElement("td");
    name.textContent = film.name;
    said.textContent = "waits";
    row.append(name, said);
    rows.append(row);
    return { film, name, said };
  });
  const button = form.querySelector("button:not([name])"), left = [...work];
  button.disabled = true;
  await Promise.all(Array.from({ length: AT_A_TIME }, async () => {
    for (let one = left.shift(); one; one = left.shift()) {
      await judgeOne(form, one, refused(one.film)).catch(() => { one.said.textContent = "The studio cannot be reached; try again."; });
    }
  }));
  button.disabled = false;
}

async function judgeOne(form, { film, name, said }, refused) {
  if (refused) { said.textContent = refused; return; }
  const sent = new FormData(form);
  sent.set("video", film);
  said.textContent = "sending";
  let answer = await fetch("/api/jobs", { method: "POST", body: sent });
  while (answer.status === 503) {
    said.textContent = "waits for a place";
    await wait(BUSY_MS);
    answer = await fetch("/api/jobs", { method: "POST", body: sent });
  }
  let job = await answer.json();
  if (answer.status !== 202) { said.textContent = job.text ?? "That did not work; try again."; return; }
  const link = Object.assign(document.createElement("a"), { href: `/verify/${job.id}`, textContent: film.name });
  name.replaceChildren(link);
  while (job.state !== "done" && job.state !== "failed") {
    said.textContent = job.frames.read ? `${job.frames.read} frames read` : "waits to be judged";
    await wait(WAIT_MS);
    job = await (await fetch(`/api/jobs/${job.id}`)).json();
  }
  const [level, words] = SAID[job.result?.verdict ?? job.result?.finding] ?? ["note", job.problem?.text ?? "no verdict"];
  said.className = `mark ${level}`;
  said.textContent = words;
}
