// Plays the visitor's own copy of the film, and moves the law beneath it in step.  Nothing of the film leaves the browser.
"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const WIDE = 1000, HIGH = 240, EDGE = 12, LEAST_WIDTHS = 0.2, MOST_HASHED = 1 << 30;
  const player = $("player"), film = $("play-film"), drawing = $("play-law");
  const course = JSON.parse(player.dataset.course);
  const long = course.to_s - course.from_s;
  const seen = course.frames.filter((frame) => frame[0] !== null);
  const places = seen.flatMap((frame) => frame.slice(1)).filter((place) => place !== null);
  const middle = (Math.max(...places) + Math.min(...places)) / 2;
  const half = Math.max(Math.max(...places) - Math.min(...places), LEAST_WIDTHS) / 2;
  let address = null, chosen = 0;

  const across = (time) => (WIDE * (time - course.from_s)) / long;
  const down = (place) => HIGH / 2 - ((place - middle) / half) * (HIGH / 2 - EDGE);

  // A line through one column of the frames; it breaks where the fringes were not seen.
  function path(column) {
    let drawn = "", pen = "M";
    for (const frame of course.frames) {
      if (frame[column] === null) { pen = "M"; continue; }
      drawn += `${pen}${across(frame[0]).toFixed(1)} ${down(frame[column]).toFixed(1)}`;
      pen = "L";
    }
    return drawn;
  }

  // The frame that is shown at a time of the film's own clock; null where none was judged within a tenth of a second.
  function nearest(time) {
    let low = 0, high = seen.length - 1;
    while (low < high) {
      const between = (low + high) >> 1;
      if (seen[between][0] < time) low = between + 1; else high = between;
    }
    const best = low > 0 && time - seen[low - 1][0] < seen[low][0] - time ? seen[low - 1] : seen[low];
    return Math.abs(best[0] - time) <= 0.1 ? best : null;
  }

  function show(played) {
    const time = course.from_s + played, at = Math.min(Math.max(across(time), 0), WIDE);
    drawing.querySelector("#play-past rect").setAttribute("width", at);
    drawing.querySelector(".now").setAttribute("d", `M${at} 0V${HIGH}`);
    const frame = nearest(time), clock = `${played.toFixed(1)} s: `;
    if (!frame) $("play-now").textContent = `${clock}the badge is not seen here`;
    else if (frame[2] === null) $("play-now").textContent = `${clock}the fringes cannot be read here`;
    else $("play-now").textContent = `${clock}fringes at ${frame[2].toFixed(2)} widths; the law says ${frame[1].toFixed(2)}`;
  }

  // Where the browser reports each frame as it is shown, the line is at that very frame.
  function follow() {
    if (film.requestVideoFrameCallback) film.requestVideoFrameCallback((now, frame) => { show(frame.mediaTime); follow(); });
  }

  function say(text, kind) {
    $("play-said").textContent = text;
    $("play-said").className = `notice ${kind}`;
    $("play-said").hidden = !text;
  }

  async function isAnother(file) {
    if (!globalThis.crypto?.subtle || file.size > MOST_HASHED) return null;
    const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", await file.arrayBuffer()));
    return [...digest].map((byte) => byte.toString(16).padStart(2, "0")).join("") !== player.dataset.sha256;
  }

  async function take(file) {
    const mine = ++chosen;
    $("play-stage").hidden = true;
    film.removeAttribute("src");
    if (address) URL.revokeObjectURL(address);
    address = null;
    if (!file) { say("", ""); return; }
    say("Comparing it with the film that was judged …", "");
    const another = await isAnother(file);
    if (mine !== chosen) return;
    if (another) { say("This is another film than the one that was judged: its SHA-256 differs.", "fail"); return; }
    say(another === null ? "Whether it is the film that was judged could not be checked here." : "It is the film that was judged.", another === null ? "undecided" : "pass");
    address = URL.createObjectURL(file);
    film.src = address;
    $("play-stage").hidden = false;
    show(0);
  }

  drawing.querySelector(".law").setAttribute("d", path(1));
  for (const line of drawing.querySelectorAll(".seen")) line.setAttribute("d", path(2));
  $("play").addEventListener("change", (event) => take(event.target.files[0]));
  for (const kind of ["dragover", "dragleave", "drop"]) {
    $("play-drop").addEventListener(kind, (event) => {
      event.preventDefault();
      $("play-drop").classList.toggle("over", kind === "dragover");
      if (kind === "drop") take(event.dataTransfer.files[0]);
    });
  }
  film.addEventListener("error", () => {
    if (!film.getAttribute("src")) return;
    $("play-stage").hidden = true;
    say("Your browser cannot play this kind of film. The verdict does not depend on that.", "undecided");
  });
  film.addEventListener("timeupdate", () => { if (!film.requestVideoFrameCallback) show(film.currentTime); });
  film.addEventListener("seeking", () => show(film.currentTime));
  const seek = (event) => {
    if (event.type === "pointermove" && !event.buttons) return;
    const box = drawing.getBoundingClientRect();
    film.currentTime = (Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1)) * long;
  };
  drawing.addEventListener("pointerdown", seek);
  drawing.addEventListener("pointermove", seek);
  follow();
  player.hidden = false;
  // Who sent the film from this page need not choose it again.
  if (globalThis.moireid?.film) take(globalThis.moireid.film);
})();
