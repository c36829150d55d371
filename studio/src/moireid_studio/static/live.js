// The live check by this device's camera: on the page Live, and behind a one-time link (data-link), whose secret is
// after the # of the address, which no browser sends to a server.
import { Check, LEAST_MS } from "./check.js";
import { $, answered, clear, judged, say, seen } from "./events.js";

const WIDTH = 1280, POOR_RATE = 15, SHOTS_MS = 2000;
const ARROWS = { left: "←", right: "→", up: "↑", down: "↓", nearer: "⊕", farther: "⊖", face: "☺" };
const form = $("who"), video = $("video"), canvas = document.createElement("canvas");
let check = null, stream = null, running = false, shots = [];

function hello() {
  if (form.dataset.link === undefined) return { claim: $("claim").value };
  return { token: location.hash.slice(1), pictures: Boolean($("agree")?.checked) };
}

async function begin(event) {
  event.preventDefault();
  say("");
  form.querySelector("button").disabled = true;
  if (!await openCamera()) {
    form.querySelector("button").disabled = false;
    return;
  }
  const on = { ready, status, prompt, prompted, verdict, error, lost: (text) => error({ text }) };
  on.challenge = () => asked("Hold the badge still. The first prompt comes soon.");
  check = new Check(form.dataset.socket, hello(), on);
}

async function openCamera() {
  if (!navigator.mediaDevices?.getUserMedia) {
    say("This browser gives no camera here. Open the page over HTTPS, or on this machine as localhost.");
    return false;
  }
  const chosen = $("camera").value;
  const which = chosen ? { deviceId: { exact: chosen } } : { facingMode: "user" };
  try {
    stream?.getTracks().forEach((track) => track.stop());
    stream = await navigator.mediaDevices.getUserMedia({
      audio: false,
      video: { width: { ideal: WIDTH }, height: { ideal: 720 }, frameRate: { ideal: 30 }, ...which },
    });
  } catch (fault) {
    say(`The camera cannot be used (${fault.name}); allow it for this page, and let no other program hold it.`);
    return false;
  }
  video.srcObject = stream;
  await video.play();
  await listCameras();
  return true;
}

// Browsers give the names of cameras only to a page that was allowed to use one.
async function listCameras() {
  const found = (await navigator.mediaDevices.enumerateDevices()).filter((one) => one.kind === "videoinput");
  const now = stream?.getVideoTracks()[0]?.getSettings().deviceId;
  $("camera").replaceChildren(...found.map((one, number) => {
    const option = Object.assign(document.createElement("option"), { value: one.deviceId });
    option.textContent = one.label || `Camera ${number + 1}`;
    option.selected = one.deviceId === now;
    return option;
  }));
  $("cameras").hidden = found.length < 2 || !found[0].label;
}

function ready() {
  form.hidden = true;
  $("stage").hidden = false;
  running = true;
  shots = [];
  next();
}

function next() {
  if (!running) return;
  if (video.requestVideoFrameCallback) {
    video.requestVideoFrameCallback((now, about) => shot(about.captureTime || now, about.presentedFrames));
  } else setTimeout(() => shot(performance.now()), 40);
}

/** presented: the number of the camera's picture; this page misses some where the device is busy. */
function shot(time, presented = shots.length ? shots.at(-1).presented + 1 : 0) {
  next();
  if (!running || !video.videoWidth) return;
  shots = [...shots.filter((one) => time - one.time < SHOTS_MS), { time, presented }];
  if (time - check.last < LEAST_MS) return;
  draw();
  check.send(canvas, time);
}

// The first picture's size is kept: another camera's pictures are fitted into it.
function draw() {
  const { videoWidth: wide, videoHeight: high } = video;
  if (!check.sent) {
    const scale = Math.min(1, WIDTH / wide);
    Object.assign(canvas, { width: Math.round(wide * scale), height: Math.round(high * scale) });
  }
  const scale = Math.min(canvas.width / wide, canvas.height / high), pen = canvas.getContext("2d", { alpha: false });
  const left = (canvas.width - scale * wide) / 2, top = (canvas.height - scale * high) / 2;
  if (left > 0.5 || top > 0.5) pen.clearRect(0, 0, canvas.width, canvas.height);
  pen.drawImage(video, left, top, scale * wide, scale * high);
}

function status(event) {
  const worst = seen(event), rate = check.rate();
  $("challenge").disabled = !(event.badge && event.face) || $("challenge").dataset.asked === "yes";
  if (!event.badge) $("advice").textContent = "No badge is seen: keep the whole badge in view, and hold a small one nearer.";
  else if (!event.face) $("advice").textContent = "No face is seen: look at the camera, in good light.";
  else $("advice").textContent = worst ? worst.text : "The badge is the claimed one, and its fringes obey the law.";
  const seconds = SHOTS_MS / 1000, got = shots.length / seconds;
  const filmed = shots.length ? (shots.at(-1).presented - shots[0].presented + 1) / seconds : 0;
  $("slow").hidden = rate === null || Math.min(rate, got) >= POOR_RATE;
  if ($("slow").hidden) return;
  if (filmed < POOR_RATE) {
    $("slow").textContent = `The camera gives ${Math.round(filmed)} pictures a second; 24 are wanted. More light mostly helps, or another camera.`;
  } else if (got < POOR_RATE) {
    $("slow").textContent = `This page gets ${Math.round(got)} of the camera's ${Math.round(filmed)} pictures a second: this device's processor is busy. Close other programs.`;
  } else $("slow").textContent = `Only ${Math.round(rate)} pictures a second are judged; 24 are wanted. ${check.cause()}`;
}

function asked(words, move, number, of) {
  $("prompt").hidden = false;
  $("prompt").classList.toggle("hold", !move);
  $("arrow").textContent = move ? ARROWS[move] : "✋";
  $("words").textContent = words;
  $("spoken").textContent = words;
  $("count").hidden = !number;
  $("count").textContent = number ? `${number} of ${of}` : "";
}

function prompt(event) {
  asked(event.text, event.move, event.number, event.of);
  if (navigator.vibrate) navigator.vibrate(80);
}

function prompted(event) {
  answered(event.reason);
  asked("Good. Hold it still there.");
}

function verdict(event) {
  leave();
  form.hidden = true;
  // What was measured for an enrolment is looked at, and kept, on its own page.
  if (event.review) location.assign(event.review);
  judged(event);
}

function error(event) {
  leave();
  say(event.text);
  // Behind a link: it may still be good, where the machine was busy.
  dispatchEvent(new Event("checkfailed"));
}

// End the camera, and show the form again; a link is used up.
function leave() {
  running = false;
  stream?.getTracks().forEach((track) => track.stop());
  stream = null;
  $("stage").hidden = $("prompt").hidden = $("count").hidden = $("slow").hidden = true;
  $("words").textContent = "";
  clear();
  form.hidden = form.dataset.link !== undefined;
  form.querySelector("button").disabled = false;
  $("challenge").disabled = true;
  $("challenge").dataset.asked = "";
}

form.addEventListener("submit", begin);
$("camera").addEventListener("change", openCamera);
$("challenge").addEventListener("click", () => {
  $("challenge").dataset.asked = "yes";
  $("challenge").disabled = true;
  $("cameras").hidden = true;
  check.request({ do: "challenge" });
});
$("end").addEventListener("click", () => {
  running = false;
  asked("Judging …");
  check.request({ do: "end" });
});
$("again")?.addEventListener("click", () => {
  $("result").hidden = true;
  form.hidden = false;
  $("claim").focus();
});
