// Reads a chosen film in the browser, from the visitor's own disk: outline of the claimed badge, and its fringes against the
// law.  A view, no verdict; the film is not sent.  Where the browser, the film or the badge does not allow it, the page
// shows nothing of it.

import { FringeTrace } from "./fringe-trace.js";
import { cameraPlace, fitHomography, mapped, scaleOf } from "./homography.js";
import { levelsOf, loadKernel, PageKernel } from "./kernel.js";
import { findPage } from "./squares.js";

const $ = (id) => document.getElementById(id);
const form = $("verify"), section = $("view"), canvas = $("view-film"), plot = $("view-law"), button = $("view-play");
/** Kinds of pictures whose first plane is brightness. */
const PLANAR = ["I420", "I420A", "I422", "I422A", "I444", "I444A", "NV12"];
/** Usual focal length, as a share of the longer side; correlation of a page that matches (`registration.MIN_CORRELATION`). */
const FOCAL = 0.75, LEAST_CORRELATION = 0.8;
/** Steps of a print's scale, and least px of a unit at which a page is followed. */
const SCALE_STEP = 1.44, LEAST_UNIT_PX = 20;
/** A page that was lost is searched within so many times its size first. */
const AROUND = 2;
/** Longer side of the picture that is drawn, px; size of the plot. */
const DRAWN_PX = 640, WIDE = 1000, HIGH = 240, EDGE = 14, LEAST_WIDTHS = 0.5;
/** While no page is seen, so long between two searches, s. */
const SEARCH_S = 0.1;
const ENDS = [[-1, -1], [1, -1], [1, 1], [-1, 1]];

/** Follows one badge through the pictures of one film. */
class BadgeView {
  #kernel; #geometry; #claim; #prints = new Map(); #row; #room = null;
  #pages = []; #searched = -Infinity;

  constructor(compiled, geometry, claim) {
    this.#kernel = new PageKernel(compiled, geometry.rules);
    [this.#geometry, this.#claim] = [geometry, claim];
    const { row, middle_mm: middle, extent_mm: extent } = geometry;
    const places = [0, 1].map((k) => Array.from({ length: row.samples * row.lines }, (_, at) => {
      const place = row.begin_mm[k] + (at % row.samples) * row.along_mm[k] + Math.floor(at / row.samples) * row.across_mm[k];
      return (place - middle[k]) / extent;
    }));
    this.#row = this.#kernel.prepareRow(...places, row.samples);
  }

  /** Takes a picture in; false where its brightness cannot be read. */
  async take(frame) {
    const { width, height } = frame.visibleRect, bytes = frame.allocationSize();
    if (!this.#room) {
      const room = { width, height, stride: width, offset: 0, bytes };
      this.#room = { ...room, ...this.#kernel.preparePicture({ ...room, ...levelsOf(frame.colorSpace.fullRange) }) };
    }
    if (width !== this.#room.width || height !== this.#room.height || bytes !== this.#room.bytes) return false;
    const [plane] = await frame.copyTo(this.#kernel.pictureBytes(this.#room));
    return plane.offset === 0 && plane.stride === width;
  }

  /** The warp of the page in the picture that was taken; null where it is not seen. */
  async find(time) {
    const [last, before] = this.#pages;
    const waits = !last && time >= this.#searched && time - this.#searched < SEARCH_S;
    let page = before ? await this.#registered(ahead(last, before, time)) : null;
    if (last) page ??= await this.#registered(last.page);
    if (!waits) page ??= await this.#searchedFor(last?.page, time);
    this.#pages = page ? [{ page, time }, last].filter(Boolean) : [];
    return page;
  }

  /** Searches where the page was, then everywhere. */
  async #searchedFor(last, time) {
    this.#searched = time;
    const picture = { ...this.#room, bytes: this.#kernel.pictureBytes(this.#room) };
    for (const box of [last && boxAround(last, picture), { left: 0, top: 0, width: picture.width, height: picture.height }]) {
      const found = box && findPage(picture, box, this.#geometry), page = found && (await this.#registered(found));
      if (page) return page;
    }
    return null;
  }

  async #registered(start) {
    const scale = scaleOf(start);
    if (!(scale > LEAST_UNIT_PX)) return null;
    const print = await this.#printAt(scale / this.#geometry.extent_mm);
    return print && this.#kernel.register(print, start, LEAST_CORRELATION);
  }

  /** The print at about a scale, px per mm, asked for once. */
  async #printAt(scale) {
    const level = Math.round(Math.log(scale) / Math.log(SCALE_STEP)), pxPerMm = SCALE_STEP ** level;
    if (!this.#prints.has(level)) {
      const asked = new URLSearchParams({ claim: this.#claim, px_per_mm: pxPerMm });
      const answer = await fetch(`/verify/view/print?${asked}`);
      if (!answer.ok) return null;
      const samples = new Float32Array(await answer.arrayBuffer()), { squares, extent_mm: extent } = this.#geometry;
      this.#prints.set(level, this.#kernel.preparePrint(samples, squares.cells.length, pxPerMm * extent, this.#geometry));
    }
    return this.#prints.get(level);
  }

  /** Light along the row, and the parallax there. */
  read(page) {
    const { row, middle_mm: middle, extent_mm: extent } = this.#geometry, { width, height } = this.#room;
    const camera = cameraPlace(page, FOCAL * Math.max(width, height), [(width - 1) / 2, (height - 1) / 2]);
    const [x, y] = [0, 1].map((k) => camera[k] * extent + middle[k]), along = row.axis[0] * x + row.axis[1] * y + row.axis[2];
    return { profile: this.#kernel.readRow(this.#row, page), parallax: (along - row.middle_mm) / Math.abs(camera[2] * extent) };
  }

  /** The badge's corners, and those of the row, px. */
  outlines(page) {
    const { row, middle_mm: middle, extent_mm: extent, outline } = this.#geometry;
    const ends = ENDS.map(([a, b]) => [0, 1].map((k) => {
      const [along, across] = [((a + 1) / 2) * (row.samples - 1), ((b + 1) / 2) * (row.lines - 1)];
      return (row.begin_mm[k] + along * row.along_mm[k] + across * row.across_mm[k] - middle[k]) / extent;
    }));
    return [outline, ends].map((places) => places.map((place) => mapped(page, ...place)));
  }
}

/** Where a page is at a time if it goes on at the same speed; where it was last, if it then folds. */
function ahead(last, before, time) {
  const share = (time - last.time) / (last.time - before.time);
  const ends = ENDS.map((place) => {
    const [now, then] = [last, before].map(({ page }) => mapped(page, ...place));
    return now.map((value, k) => value + share * (value - then[k]));
  });
  return fitHomography(ENDS, ends) ?? last.page;
}

/** The part of a picture in which a page is that was there a moment ago. */
function boxAround(page, { width, height }) {
  const ends = ENDS.map(([x, y]) => mapped(page, AROUND * x, AROUND * y));
  const [left, top] = [0, 1].map((k) => Math.max(Math.floor(Math.min(...ends.map((end) => end[k]))), 0));
  const [right, bottom] = [width, height].map((most, k) => Math.min(Math.ceil(Math.max(...ends.map((end) => end[k]))), most));
  const box = { left, top, width: right - left, height: bottom - top };
  return box.width > LEAST_UNIT_PX && box.height > LEAST_UNIT_PX ? box : null;
}

/** A point of the coded picture as it is shown, as shares of width and height. */
function shown([x, y], frame) {
  const a = (x + 0.5) / frame.visibleRect.width, b = (y + 0.5) / frame.visibleRect.height;
  return { 90: [1 - b, a], 180: [1 - a, 1 - b], 270: [b, 1 - a] }[frame.rotation ?? 0] ?? [a, b];
}

function drawPicture(frame, player, outlines) {
  const factor = Math.min(DRAWN_PX / Math.max(player.videoWidth, player.videoHeight), 1), pen = canvas.getContext("2d");
  const [width, height] = [player.videoWidth, player.videoHeight].map((side) => Math.round(side * factor));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  pen.drawImage(frame, 0, 0, width, height);
  outlines?.forEach((corners, k) => {
    pen.beginPath();
    for (const corner of corners) { const [a, b] = shown(corner, frame); pen.lineTo(a * width, b * height); }
    pen.closePath();
    for (const [stroke, wide] of k ? [["#7db8ee", 2]] : [["#12171d", 6], ["#ffffff", 2.5]]) {
      [pen.strokeStyle, pen.lineWidth, pen.lineJoin] = [stroke, wide, "round"];
      pen.stroke();
    }
  });
}

function drawTrace(lines, duration) {
  const places = lines.filter(Boolean).flatMap(({ seen, law }) => [seen, law]);
  const high = Math.max(...places), low = Math.min(...places), half = Math.max(high - low, LEAST_WIDTHS) / 2;
  const last = lines.at(-1), whole = Number.isFinite(duration) ? duration : last.time || 1;
  const across = (time) => (WIDE * time) / whole;
  const down = (place) => HIGH / 2 - ((place - (high + low) / 2) / half) * (HIGH / 2 - EDGE);
  for (const name of ["law", "seen"]) {
    const point = (one) => `${across(one.time).toFixed(1)} ${down(one[name]).toFixed(1)}`;
    const drawn = lines.map((one, k) => (one ? (lines[k - 1] ? "L" : "M") + point(one) : ""));
    plot.querySelector(`.${name}`).setAttribute("d", drawn.join(""));
  }
  plot.querySelector(".now").setAttribute("d", `M${across(last.time).toFixed(1)} 0V${HIGH}`);
}

let compiled = null, player = null, asked = 0;

function stop() {
  asked++;
  section.hidden = true;
  if (!player) return;
  player.pause();
  URL.revokeObjectURL(player.src);
  player.removeAttribute("src");
  player = null;
}

/** What the form says; null where there is nothing to view. */
function wish() {
  const film = form.video.files[0], claim = form.claim.value.trim();
  const one = form.video.files.length === 1 && form.kind.value === "verify" && !form.badge.files.length;
  return one && claim ? { film, claim } : null;
}

async function begin() {
  stop();
  const mine = asked, wanted = wish();
  if (!wanted) return;
  const answer = await fetch(`/verify/view?${new URLSearchParams({ claim: wanted.claim })}`);
  const geometry = answer.ok ? await answer.json() : null;
  compiled ??= geometry && (await loadKernel());
  if (mine !== asked || !geometry) return;
  player = document.createElement("video");
  Object.assign(player, { muted: true, playsInline: true, src: URL.createObjectURL(wanted.film) });
  const view = new BadgeView(compiled, geometry, wanted.claim), trace = new FringeTrace(geometry.row);
  const own = player, goes = () => mine === asked && section.isConnected;
  const name = () => { button.textContent = own.ended ? "Play again" : own.paused ? "Play" : "Pause"; };
  for (const kind of ["play", "pause", "ended"]) own.addEventListener(kind, name);
  own.addEventListener("seeking", () => trace.clear());
  follow(own, view, trace, goes);
  // One frame is looked at in any case; motion only where the visitor has nothing against it.
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) own.currentTime = 0.001;
  else await own.play();
}

/** Looks at each frame that is played. */
function follow(own, view, trace, goes) {
  const next = () => own.requestVideoFrameCallback((now, { mediaTime }) => {
    look(own, view, trace, mediaTime).catch(() => false).then((able) => { if (goes()) (able ? next : stop)(); });
  });
  next();
}

async function look(own, view, trace, time) {
  const frame = new VideoFrame(own);
  try {
    if (!PLANAR.includes(frame.format) || frame.flip || !(await view.take(frame))) return false;
    const page = await view.find(time), outlines = page && view.outlines(page);
    if (page) {
      const { profile, parallax } = view.read(page);
      trace.add(time, profile, parallax);
      section.hidden = false;
      const lines = trace.lines(), last = lines.at(-1);
      drawTrace(lines, own.duration);
      const [seen, law] = [last.seen, last.law].map((widths) => widths.toFixed(2));
      $("view-now").textContent = `${time.toFixed(1)} s: fringes at ${seen} widths; the law says ${law}`;
      section.dispatchEvent(new CustomEvent("badge", { detail: { time, outline: outlines[0], ...last } }));
    } else $("view-now").textContent = `${time.toFixed(1)} s: the badge is not followed here`;
    drawPicture(frame, own, outlines);
    return true;
  } finally {
    frame.close();
  }
}

if (globalThis.WebAssembly && globalThis.VideoFrame && "requestVideoFrameCallback" in HTMLVideoElement.prototype) {
  // What cannot be read here is read by the studio alone, once the film is sent.
  const again = () => begin().catch(stop);
  const fields = [form.video, form.claim, form.badge, ...form.querySelectorAll("input[name=kind]")];
  for (const field of fields) field.addEventListener("change", again);
  button.addEventListener("click", () => { if (player?.paused) player.play().catch(stop); else player?.pause(); });
}
