// Records a capture with this device's camera and gives it to the form as a file; without a camera, a file is uploaded.

const TYPES = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];
const LONGEST_S = 60;

class Recorder {
  constructor(form) {
    this.form = form;
    this.panel = form.querySelector("[data-camera]");
    this.video = this.panel.querySelector("video");
    this.status = this.panel.querySelector("[data-status]");
    this.begin = this.panel.querySelector("[data-begin]");
    this.end = this.panel.querySelector("[data-end]");
    this.chosen = form.querySelector("input[name='video']");
    this.filmed = form.querySelector("[data-phone] input");
    this.video.hidden = true;
    // A phone's own camera app films better than a page can; the field's attribute `capture` opens it.
    const phone = matchMedia("(pointer: coarse)").matches;
    form.querySelector("[data-phone]").hidden = !phone;
    this.panel.hidden = phone || !(navigator.mediaDevices?.getUserMedia && window.MediaRecorder);
    this.begin.addEventListener("click", () => this.record());
    this.end.addEventListener("click", () => this.recorder.stop());
    this.chosen.addEventListener("change", () => this.take(this.chosen.files));
    this.filmed.addEventListener("change", () => this.take(this.filmed.files));
    form.addEventListener("submit", (event) => this.check(event));
  }

  /** Let the form have these files. */
  take(files) {
    this.chosen.files = files;
    this.chosen.setCustomValidity("");
  }

  check(event) {
    const [film] = this.chosen.files, most = Number(this.form.dataset.mostBytes);
    if (film && film.size <= most) return;
    event.preventDefault();
    this.chosen.setCustomValidity(film
      ? `This film has ${Math.ceil(film.size / 1048576)} MB; at most ${most / 1048576} MB are taken. Cut it, or film again.`
      : "Choose a film, or record one, before it can be measured.");
    this.chosen.reportValidity();
  }

  async record() {
    try {
      this.stream = await navigator.mediaDevices.getUserMedia({
        audio: false,
        video: { facingMode: "environment", width: { ideal: 1920 }, height: { ideal: 1080 }, frameRate: { ideal: 30 } },
      });
    } catch (error) {
      this.status.textContent = `The camera cannot be used (${error.name}); choose a film instead.`;
      return;
    }
    this.video.srcObject = this.stream;
    this.video.hidden = false;
    await this.video.play();
    const mimeType = TYPES.find((type) => MediaRecorder.isTypeSupported(type)), parts = [];
    this.recorder = new MediaRecorder(this.stream, { mimeType, videoBitsPerSecond: 16_000_000 });
    this.recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
    this.recorder.addEventListener("stop", () => this.finish(parts));
    this.recorder.start(1000);
    this.begin.hidden = true;
    this.end.hidden = false;
    this.end.focus();
    this.since = performance.now();
    this.timer = setInterval(() => this.tick(), 500);
    this.tick();
  }

  tick() {
    const seconds = Math.floor((performance.now() - this.since) / 1000);
    this.status.textContent = `Recording, ${seconds} s: move the badge 20 cm to and fro sideways.`;
    if (seconds >= LONGEST_S) this.recorder.stop();
  }

  finish(parts) {
    clearInterval(this.timer);
    for (const track of this.stream.getTracks()) track.stop();
    const kind = this.recorder.mimeType.split(";")[0];
    const file = new File(parts, `capture.${kind.endsWith("mp4") ? "mp4" : "webm"}`, { type: kind });
    const transfer = new DataTransfer();
    transfer.items.add(file);
    this.take(transfer.files);
    this.video.srcObject = null;
    this.video.hidden = true;
    this.end.hidden = true;
    this.begin.hidden = false;
    this.begin.focus();
    this.status.textContent = `Recorded ${(file.size / 1e6).toFixed(1)} MB; press Measure, or record again.`;
  }
}

for (const form of document.querySelectorAll("form[data-record]")) new Recorder(form);
