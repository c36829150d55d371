// The preview's controls: pointer, keys, sliders and the phone's tilt move the camera, `fringes.js` draws what it sees.

import { BadgePicture, cameraAt, movedMm } from "./fringes.js";

const KEY_STEP = 0.02;

/** The rotation of a device from its angles in degrees, as W3C's DeviceOrientation has it: Z, then X, then Y. */
function rotation({ alpha, beta, gamma }) {
  const [a, b, c] = [alpha || 0, beta || 0, gamma || 0].map((degrees) => (degrees * Math.PI) / 180);
  const [ca, sa, cb, sb, cc, sc] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b), Math.cos(c), Math.sin(c)];
  return [
    [ca * cc - sa * sb * sc, -cb * sa, cc * sa * sb + ca * sc],
    [cc * sa + ca * sb * sc, ca * cb, sa * sc - ca * cc * sb],
    [-cb * sc, sb, cb * cc],
  ];
}

/**
 * From where a person who does not move sees the screen, as tangents to the right and down, once the phone has turned
 * from `first` to `now`; at `first` they looked straight at it.  `turned`: screen.orientation.angle, degrees.
 */
export function tiltTangents(first, now, turned) {
  const before = rotation(first), after = rotation(now);
  // The screen's old normal, in the axes of the device as it is held now.
  const seen = [0, 1, 2].map((k) => [0, 1, 2].reduce((sum, row) => sum + after[row][k] * before[row][2], 0));
  const angle = (turned * Math.PI) / 180;
  const right = Math.cos(angle) * seen[0] - Math.sin(angle) * seen[1];
  const up = Math.sin(angle) * seen[0] + Math.cos(angle) * seen[1];
  const depth = Math.max(seen[2], 0.05);
  return [right / depth, -up / depth];
}

/** A direction and an amount in words: "8° from the right". */
function side(tangent, positive, negative) {
  const degrees = Math.round((Math.abs(Math.atan(tangent)) * 180) / Math.PI);
  return degrees ? `${degrees}° ${tangent > 0 ? positive : negative}` : "";
}

/** Brings one preview to life: `root` bears the law as JSON, and holds a canvas, three sliders, a line of words and a button. */
export class Preview {
  constructor(root) {
    this.law = JSON.parse(root.dataset.preview);
    this.canvas = root.querySelector("canvas");
    this.sliders = ["right", "down", "metres"].map((name) => root.querySelector(`input[name='view-${name}']`));
    this.words = root.querySelector("[data-words]");
    this.tilt = root.querySelector("button[data-tilt]");
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.picture = new BadgePicture(this.canvas, this.law);
    this.listen();
    this.show();
  }

  listen() {
    for (const slider of this.sliders) slider.addEventListener("input", () => this.show());
    this.canvas.addEventListener("pointermove", (event) => {
      // With reduced motion, the fringes follow only a pressed pointer, not one that passes over them.
      if (this.calm.matches && !event.buttons) return;
      const box = this.canvas.getBoundingClientRect(), reach = this.law.camera.reach;
      const share = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
      this.look(...share.map((value) => (2 * value - 1) * reach));
    });
    this.canvas.addEventListener("keydown", (event) => {
      const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] || [0, 0];
      if (!dx && !dy) return;
      event.preventDefault();
      const [right, down] = this.sliders.map((slider) => Number(slider.value));
      this.look(right + dx * KEY_STEP, down + dy * KEY_STEP);
    });
    if (!("DeviceOrientationEvent" in window) || !matchMedia("(pointer: coarse)").matches) return;
    this.tilt.hidden = false;
    this.tilt.addEventListener("click", () => this.followTilt());
  }

  /** Follow the phone's tilt; some systems (iOS) first ask the owner for permission. */
  async followTilt() {
    const ask = window.DeviceOrientationEvent.requestPermission;
    if (ask && (await ask.call(window.DeviceOrientationEvent).catch(() => "denied")) !== "granted") {
      this.tilt.textContent = "The phone did not allow it; use the sliders";
      return;
    }
    let first = null;
    addEventListener("deviceorientation", (event) => {
      if (event.beta === null) return;
      first ??= { alpha: event.alpha, beta: event.beta, gamma: event.gamma };
      this.look(...tiltTangents(first, event, screen.orientation?.angle ?? window.orientation ?? 0));
    });
    this.tilt.hidden = true;
  }

  /** Put the camera at tangents to the right and down, within its reach. */
  look(right, down) {
    const reach = this.law.camera.reach;
    [right, down].forEach((value, k) => { this.sliders[k].value = Math.min(Math.max(value, -reach), reach); });
    this.show();
  }

  /** Draw at the next screen refresh, once for any number of events. */
  show() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const [right, down, metres] = this.sliders.map((slider) => Number(slider.value));
      const camera = cameraAt(this.law, right, down, metres * 1000);
      this.picture.draw(camera);
      this.describe(right, down, metres, camera);
    });
  }

  describe(right, down, metres, camera) {
    const sides = [side(right, "from the right", "from the left"), side(down, "from below", "from above")];
    const from = sides.filter(Boolean).join(" and ") || "straight ahead";
    const moved = this.law.gratings.map((grating, g) => {
      const mm = movedMm(this.law, g, camera), [right, down] = grating.own[0].map((part) => part * Math.sign(mm));
      const ways = [[down, "down", "up"], [right, "right", "left"]].filter(([part]) => Math.abs(part) > 0.1);
      const way = ways.map(([part, positive, negative]) => (part > 0 ? positive : negative)).join(" ");
      return Math.abs(mm) < 0.5 ? "" : `${Math.abs(mm).toFixed(0)} mm ${way}`;
    });
    const shown = [...new Set(moved.filter(Boolean))].join(" and ");
    const motion = shown ? `the fringes of the first row have moved ${shown}` : "no fringe has moved";
    this.words.textContent = `Seen ${from}, ${metres.toFixed(2)} m away: ${motion}.`;
    this.sliders[0].setAttribute("aria-valuetext", sides[0] || "straight ahead");
    this.sliders[1].setAttribute("aria-valuetext", sides[1] || "straight ahead");
    this.sliders[2].setAttribute("aria-valuetext", `${metres.toFixed(2)} metres`);
  }
}

for (const root of document.querySelectorAll("[data-preview]")) new Preview(root);
