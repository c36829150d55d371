// The form of a film: dropping a file, progress of the upload.  The form also works without this.
"use strict";
const form = document.getElementById("verify");
const video = document.getElementById("video");
const drop = document.getElementById("drop");
const error = document.getElementById("error");
const sending = document.getElementById("sending");
const bar = document.getElementById("bar");
const button = form.querySelector("button");

document.getElementById("drop-hint").hidden = false;
video.multiple = true;
for (const kind of ["dragover", "dragleave", "drop"]) {
  drop.addEventListener(kind, (event) => {
    event.preventDefault();
    drop.classList.toggle("over", kind === "dragover");
    if (kind !== "drop" || !event.dataTransfer.files.length) return;
    video.files = event.dataTransfer.files;
    video.dispatchEvent(new Event("change"));
  });
}

const claimed = document.getElementById("claimed");
for (const radio of form.querySelectorAll("input[name=kind]")) {
  radio.addEventListener("change", () => { claimed.hidden = form.kind.value === "identify"; });
}

function fail(text) {
  error.textContent = text;
  error.hidden = false;
  sending.hidden = true;
  button.disabled = false;
}

/** Why a film cannot be sent; empty where it can. */
function tooLarge(film) {
  const most = Number(form.dataset.mostBytes);
  if (film.size <= most) return "";
  return `${film.name} has ${Math.ceil(film.size / 1048576)} MB; at most ${most / 1048576} MB are taken. Cut it, or film again.`;
}

form.addEventListener("submit", (event) => {
  event.preventDefault();
  error.hidden = true;
  const films = [...video.files];
  if (films.length > 1) { judgeAll(form, films, tooLarge); return; }
  const large = tooLarge(films[0]);
  if (large) { fail(large); return; }
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
    if (request.status === 202) follow(`/verify/${request.response.id}`);
    else fail(request.response?.text ?? "That did not work; try again.");
  });
  request.send(new FormData(form));
});
// The pages of the job come into this one, so that the chosen film is still at hand where its verdict is shown.
async function follow(address) {
  const answer = await fetch(address).catch(() => null);
  if (!answer) { location.assign(address); return; }
  const came = new DOMParser().parseFromString(await answer.text(), "text/html");
  if (location.pathname !== address) {
    globalThis.moireid = { film: video.files[0], next: () => follow(address) };
    history.pushState(null, "", address);
    addEventListener("popstate", () => location.reload());
  }
  document.title = came.title;
  document.getElementById("main").replaceWith(document.adoptNode(came.getElementById("main")));
  for (const sheet of came.querySelectorAll("head link[rel=stylesheet]")) {
    if (!document.querySelector(`link[href="${sheet.getAttribute("href")}"]`)) document.head.append(document.adoptNode(sheet));
  }
  for (const script of came.querySelectorAll("head script[src]")) {
    document.head.append(Object.assign(document.createElement("script"), { src: script.getAttribute("src") }));
  }
  scrollTo(0, 0);
  document.getElementById("main").focus();
}
// After going back from the verdict, the form is ready again.
addEventListener("pageshow", () => { sending.hidden = true; button.disabled = false; });
