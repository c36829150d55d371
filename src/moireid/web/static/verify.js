// The form of a film: dropping a file, progress of the upload, suggestions for names.  The form also works without this.
"use strict";
const form = document.getElementById("verify");
const video = document.getElementById("video");
const drop = document.getElementById("drop");
const error = document.getElementById("error");
const sending = document.getElementById("sending");
const bar = document.getElementById("bar");
const button = form.querySelector("button");

document.getElementById("drop-hint").hidden = false;
for (const kind of ["dragover", "dragleave", "drop"]) {
  drop.addEventListener(kind, (event) => {
    event.preventDefault();
    drop.classList.toggle("over", kind === "dragover");
    if (kind === "drop" && event.dataTransfer.files.length) video.files = event.dataTransfer.files;
  });
}

const claimed = document.getElementById("claimed");
for (const radio of form.querySelectorAll("input[name=kind]")) {
  radio.addEventListener("change", () => { claimed.hidden = form.kind.value === "identify"; });
}

const claim = document.getElementById("claim");
const people = document.getElementById("people");
let asked = 0;
claim.addEventListener("input", async () => {
  const mine = ++asked;
  const answer = await fetch(`/api/registry?limit=10&search=${encodeURIComponent(claim.value)}`);
  if (!answer.ok || mine !== asked) return;
  const names = new Set((await answer.json()).badges.map((badge) => badge.name));
  people.replaceChildren(...[...names].map((name) => Object.assign(document.createElement("option"), { value: name })));
});

function fail(text) {
  error.textContent = text;
  error.hidden = false;
  sending.hidden = true;
  button.disabled = false;
}

form.addEventListener("submit", (event) => {
  event.preventDefault();
  error.hidden = true;
  sending.hidden = false;
  button.disabled = true;
  const request = new XMLHttpRequest();
  request.open("POST", "/api/jobs");
  request.responseType = "json";
  request.upload.addEventListener("progress", (step) => {
    if (!step.lengthComputable) return;
    bar.value = step.loaded / step.total;
    document.getElementById("sent").textContent = `Sending: ${Math.round(100 * bar.value)} %`;
  });
  request.addEventListener("error", () => fail("The studio cannot be reached; try again."));
  request.addEventListener("load", () => {
    if (request.status === 202) location.assign(`/verify/${request.response.id}`);
    else fail(request.response?.text ?? "That did not work; try again.");
  });
  request.send(new FormData(form));
});
// After going back from the verdict, the form is ready again.
addEventListener("pageshow", () => { sending.hidden = true; button.disabled = false; });
