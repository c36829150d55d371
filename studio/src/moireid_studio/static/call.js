// Check a call: its window is shared with this page, one person's tile of it is chosen, and that tile alone is sent.
import { Check } from "./check.js";
import { $, answered, clear, judged, say, seen } from "./events.js";
import { findTiles, movingTile, stillThere } from "./tiles.js";

const FPS = 24, MOST_WIDTH = 1280, FIND_WIDTH = 640, WAVE_MS = 2500, LOOK_MS = 700, POOR_RATE = 12, MISSES = 3;
const form = $("who"), least = Number(form.dataset.leastPx);
const shared = $("shared"), tile = $("tile"), small = document.createElement("canvas");
let stream = null, check = null, tiles = [], box = null, drawn = null, timers = [], misses = 0, sized = "";

async function share(event) {
  event.preventDefault();
  say("");
  if (!navigator.mediaDevices?.getDisplayMedia) {
    say("This browser cannot share a window with this page. Use Chromium or Firefox on a computer, over HTTPS or as localhost.");
    return;
  }
  try {
    stream = await navigator.mediaDevices.getDisplayMedia({ audio: false, video: { frameRate: { ideal: FPS, max: 30 } } });
  } catch (fault) {
    say(fault.name === "NotAllowedError" ? "No window was shared; choose the call's window or tab." : `The window cannot be shared (${fault.name}).`);
    return;
  }
  stream.getVideoTracks()[0].addEventListener("ended", () => { if (stream) fail("The window is no longer shared; begin again."); });
  shared.srcObject = stream;
  await shared.play();
  form.hidden = true;
  $("choose").hidden = false;
  $("choose").focus();
  timers.push(setInterval(outline, LOOK_MS));
  outline();
}

// The shared window, small enough to look for tiles in.
function glance() {
  const scale = Math.min(1, FIND_WIDTH / shared.videoWidth);
  Object.assign(small, { width: Math.round(shared.videoWidth * scale), height: Math.round(shared.videoHeight * scale) });
  const pen = small.getContext("2d", { willReadFrequently: true, alpha: false });
  pen.drawImage(shared, 0, 0, small.width, small.height);
  return pen.getImageData(0, 0, small.width, small.height);
}

const grown = (one) => {
  const scale = shared.videoWidth / small.width;
  return { x: one.x * scale, y: one.y * scale, w: one.w * scale, h: one.h * scale };
};

function outline() {
  if (!shared.videoWidth || check) return;
  const found = findTiles(glance());
  // A button that is renewed while someone presses it is never pressed.
  if (!drawn && JSON.stringify(found) === JSON.stringify(tiles)) return;
  tiles = found;
  $("outlines").replaceChildren(...tiles.map((one) => {
    const mark = document.createElement("button");
    mark.type = "button";
    mark.className = "outline";
    const { w, h } = grown(one);
    mark.setAttribute("aria-label", `Tile of ${Math.round(w)} by ${Math.round(h)} pixels`);
    place(mark, one);
    mark.addEventListener("click", () => choose(grown(one), false));
    return mark;
  }), ...(drawn ? [drawn.mark] : []));
}

function place(mark, one) {
  const share = (part, all) => `${(100 * part) / all}%`;
  Object.assign(mark.style, { left: share(one.x, small.width), top: share(one.y, small.height), width: share(one.w, small.width), height: share(one.h, small.height) });
}

// Where no tile is found, one is drawn with the pointer.
function pointed(event) {
  const around = $("window").getBoundingClientRect();
  return { x: (event.clientX - around.left) / around.width * small.width, y: (event.clientY - around.top) / around.height * small.height };
}

$("window").addEventListener("pointerdown", (event) => { drawn = { from: pointed(event), mark: Object.assign(document.createElement("div"), { className: "outline drawn" }) }; });
$("window").addEventListener("pointermove", (event) => {
  if (!drawn) return;
  const to = pointed(event), { from } = drawn;
  drawn.box = { x: Math.min(from.x, to.x), y: Math.min(from.y, to.y), w: Math.abs(to.x - from.x), h: Math.abs(to.y - from.y) };
  place(drawn.mark, drawn.box);
  if (!drawn.mark.isConnected && drawn.box.w > 8) $("outlines").append(drawn.mark);
});
addEventListener("pointerup", () => {
  const made = drawn?.box;
  drawn = null;
  if (made && made.w > 0.05 * small.width && made.h > 0.05 * small.height) choose(grown(made), true);
});

function wave() {
  const before = glance();
  $("wave").disabled = true;
  $("found").textContent = "Looking for what moves …";
  setTimeout(() => {
    $("wave").disabled = false;
    $("found").textContent = "";
    if (!stream) return;
    tiles = findTiles(glance());
    choose(grown(movingTile(tiles, before, glance())), false);
  }, WAVE_MS);
}

/** Begin with a box in the window; by hand: one whose place no outline gives. */
function choose(chosen, byHand) {
  if (check) return;
  box = { ...chosen, byHand };
  sized = `${shared.videoWidth} ${shared.videoHeight}`;
  const scale = Math.min(1, MOST_WIDTH / box.w);
  // An even size, which every codec can take.
  Object.assign(tile, { width: 2 * Math.round(box.w * scale / 2), height: 2 * Math.round(box.h * scale / 2) });
  if (tile.width < 120 || tile.height < 120) {
    say(`The tile is ${tile.width} px wide; enlarge it to ${least} px or more, or pin the person.`);
    return;
  }
  say("");
  stop();
  misses = 0;
  const on = { ready, status, challenge, prompt, prompted, verdict, error: (event) => fail(event.text), lost: fail };
  check = new Check("/call/socket", { claim: $("claim").value }, on);
}

function ready() {
  $("choose").hidden = true;
  $("stage").hidden = false;
  quality();
  timers.push(setInterval(shot, 1000 / FPS), setInterval(look, LOOK_MS));
}

function shot() {
  if (!shared.videoWidth || !check) return;
  tile.getContext("2d", { alpha: false }).drawImage(shared, box.x, box.y, box.w, box.h, 0, 0, tile.width, tile.height);
  check.send(tile, performance.now());
}

// A tile that left its place may show another person now.
function look() {
  if (!check) return;
  const there = sized === `${shared.videoWidth} ${shared.videoHeight}`;
  const scale = small.width / shared.videoWidth;
  const now = { x: box.x * scale, y: box.y * scale, w: box.w * scale, h: box.h * scale };
  misses = there && (box.byHand || stillThere(findTiles(glance()), now)) ? 0 : misses + 1;
  if (misses < (there ? MISSES : 1)) return;
  stop();
  asked("Judging …");
  check.request({ do: "moved" });
}

function quality() {
  const poor = [], rate = check.rate();
  if (box.w < least) poor.push(`The tile is ${Math.round(box.w)} px wide; enlarge it to ${least} px or more, or pin the person.`);
  if (rate !== null && rate < POOR_RATE) poor.push(`Only ${Math.round(rate)} pictures a second are judged; 24 are wanted. ${check.cause()}`);
  if (document.hidden) poor.push("This page is hidden, and browsers slow it down then; put it next to the call.");
  $("poor").hidden = !poor.length;
  $("poor").textContent = poor.join(" ");
}

function status(event) {
  const worst = seen(event);
  quality();
  $("challenge").disabled = !(event.badge && event.face) || $("challenge").dataset.asked === "yes";
  if (!event.badge) $("advice").textContent = "No badge is seen. Say: “Please hold your badge below your face, the whole of it in the picture.”";
  else if (!event.face) $("advice").textContent = "No face is seen. Say: “Please look at the camera, in good light.”";
  else $("advice").textContent = worst ? worst.text : "The badge is the claimed one, and its fringes obey the law.";
}

function asked(words, aloud, number, of) {
  $("prompt").hidden = false;
  $("prompt").classList.toggle("hold", !aloud);
  $("aloud").hidden = !aloud;
  $("words").textContent = aloud ? `“${words}”` : words;
  $("spoken").textContent = (aloud ? "Read aloud: " : "") + words;
  $("count").hidden = !number;
  $("count").textContent = number ? `${number} of ${of}` : "";
}

const challenge = () => asked("Please hold the badge still, below your face.", true);
const prompt = (event) => asked(event.aloud, true, event.number, event.of);

function prompted(event) {
  answered(event.reason);
  asked("Followed. Wait for the next sentence.");
}

function verdict(event) {
  leave();
  form.hidden = true;
  judged(event);
}

function fail(text) {
  leave();
  say(text);
}

function stop() {
  timers.forEach(clearInterval);
  timers = [];
}

function leave() {
  stop();
  const track = stream;
  stream = null;
  track?.getTracks().forEach((one) => one.stop());
  check?.close();
  check = null;
  $("stage").hidden = $("choose").hidden = $("prompt").hidden = $("count").hidden = $("poor").hidden = true;
  clear();
  form.hidden = false;
  $("challenge").disabled = true;
  $("challenge").dataset.asked = "";
}

form.addEventListener("submit", share);
$("wave").addEventListener("click", wave);
$("whole").addEventListener("click", () => choose({ x: 0, y: 0, w: shared.videoWidth, h: shared.videoHeight }, true));
$("challenge").addEventListener("click", () => {
  $("challenge").dataset.asked = "yes";
  $("challenge").disabled = true;
  check.request({ do: "challenge" });
});
$("end").addEventListener("click", () => {
  stop();
  asked("Judging …");
  check.request({ do: "end" });
});
$("again").addEventListener("click", () => {
  $("result").hidden = true;
  form.hidden = false;
  $("claim").focus();
});
