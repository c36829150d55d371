// The live check: the camera's pictures out, events in.  Pictures that cannot be sent in time are dropped, never queued.
"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const WIDTH = 1280, QUALITY = 0.85, LEAST_MS = 28, MOST_AHEAD = 5, MOST_BUFFERED = 1 << 20;
  const ARROWS = { left: "←", right: "→", up: "↑", down: "↓", nearer: "⊕", farther: "⊖", face: "☺" };
  const MARKS = { pass: "✓", fail: "✗", undecided: "?", note: "·" };
  let socket = null, stream = null, sent = 0, taken = 0, last = -Infinity, running = false, over = true;
  const canvas = document.createElement("canvas");

  function say(problem) {
    $("problem").textContent = problem || "";
    $("problem").hidden = !problem;
  }

  function begin(event) {
    event.preventDefault();
    if (!navigator.mediaDevices || !navigator.mediaDevices.getUserMedia) {
      say("This browser gives no camera here. Open the page over HTTPS, or on this machine as localhost.");
      return;
    }
    say("");
    sent = taken = 0;
    last = -Infinity;
    over = false;
    socket = new WebSocket((location.protocol === "https:" ? "wss://" : "ws://") + location.host + "/live/socket");
    socket.onopen = () => socket.send(JSON.stringify({ claim: $("claim").value }));
    socket.onmessage = (message) => heard(JSON.parse(message.data));
    socket.onclose = () => {
      if (!over) {
        leave();
        say($("problem").textContent || "The connection was lost, or you may not use this; begin again.");
      }
    };
    $("who").querySelector("button").disabled = true;
  }

  async function openCamera() {
    try {
      stream = await navigator.mediaDevices.getUserMedia({
        audio: false,
        video: { width: { ideal: WIDTH }, height: { ideal: 720 }, frameRate: { ideal: 30 }, facingMode: "user" },
      });
    } catch (error) {
      over = true;
      socket.close();
      leave();
      say("The camera cannot be used (" + error.name + "); allow it for this page, and let no other program hold it.");
      return;
    }
    $("video").srcObject = stream;
    await $("video").play();
    $("who").hidden = true;
    $("stage").hidden = false;
    running = true;
    next();
  }

  function next() {
    const video = $("video");
    if (!running) return;
    if (video.requestVideoFrameCallback) {
      video.requestVideoFrameCallback((now, about) => shot(about.captureTime || now));
    } else {
      setTimeout(() => shot(performance.now()), 40);
    }
  }

  function shot(time) {
    next();
    if (!running || time - last < LEAST_MS || socket.readyState !== WebSocket.OPEN) return;
    if (sent - taken >= MOST_AHEAD || socket.bufferedAmount > MOST_BUFFERED) return;
    const video = $("video"), scale = Math.min(1, WIDTH / video.videoWidth);
    const width = Math.round(video.videoWidth * scale), height = Math.round(video.videoHeight * scale);
    if (!width) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    canvas.getContext("2d", { alpha: false }).drawImage(video, 0, 0, width, height);
    last = time;
    sent += 1;
    canvas.toBlob((picture) => {
      const clock = new DataView(new ArrayBuffer(8));
      clock.setFloat64(0, time);
      if (picture && socket.readyState === WebSocket.OPEN) socket.send(new Blob([clock.buffer, picture]));
      else sent -= 1;
    }, "image/jpeg", QUALITY);
  }

  function heard(event) {
    ({
      ready: openCamera, taken: () => { taken = event.frames; }, status: () => seen(event),
      challenge: () => { asked("Hold the badge still. The first prompt comes soon."); },
      prompt: () => prompted(event), prompted: () => answered(event), verdict: () => judged(event),
      error: () => { over = true; leave(); say(event.text); },
    }[event.event] || (() => {}))();
  }

  function state(id, value) {
    $(id).dataset.state = value;
  }

  function seen(event) {
    state("see-badge", event.badge ? "pass" : "undecided");
    state("see-face", event.face ? "pass" : "undecided");
    state("see-law", { accept: "pass", reject: "fail", inconclusive: "undecided" }[event.verdict]);
    $("challenge").disabled = !(event.badge && event.face) || $("challenge").dataset.asked === "yes";
    const worst = event.reasons.find((one) => one.level === "fail") || event.reasons.find((one) => one.level === "undecided");
    if (!event.badge) $("advice").textContent = "No badge is seen: hold it so that its four markers are in the picture.";
    else if (!event.face) $("advice").textContent = "No face is seen: look at the camera, in good light.";
    else $("advice").textContent = worst ? worst.text : "The badge is the claimed one, and its fringes obey the law.";
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

  function prompted(event) {
    asked(event.text, event.move, event.number, event.of);
    if (navigator.vibrate) navigator.vibrate(80);
  }

  function answered(event) {
    const line = document.createElement("li"), mark = document.createElement("span");
    mark.className = "mark " + event.reason.level;
    mark.textContent = MARKS[event.reason.level] + " ";
    line.append(mark, event.reason.text);
    $("prompts").append(line);
    asked("Good. Hold it still there.");
  }

  function judged(event) {
    over = true;
    leave();
    $("who").hidden = true;
    const headline = event.headline;
    $("verdict").className = "verdict " + headline.colour;
    $("verdict-words").textContent = `${headline.mark} ${headline.title}`;
    $("verdict-text").textContent = headline.text;
    $("verdict-next").textContent = headline.advice;
    $("reasons").replaceChildren(...event.reasons.map((reason) => {
      const row = document.createElement("tr"), mark = document.createElement("td"), words = document.createElement("td");
      mark.className = "mark " + reason.level;
      mark.textContent = MARKS[reason.level] + " " + { pass: "holds", fail: "fails", undecided: "open", note: "note" }[reason.level];
      words.textContent = reason.text;
      row.append(mark, words);
      return row;
    }));
    $("result").hidden = false;
    $("result").focus();
  }

  // End the camera and the session, and show the form again.
  function leave() {
    running = false;
    if (stream) stream.getTracks().forEach((track) => track.stop());
    stream = null;
    $("stage").hidden = true;
    $("prompt").hidden = $("count").hidden = true;
    $("prompts").replaceChildren();
    $("who").hidden = false;
    $("who").querySelector("button").disabled = false;
    $("challenge").disabled = true;
    $("challenge").dataset.asked = "";
    ["see-badge", "see-face", "see-law"].forEach((id) => state(id, ""));
  }

  $("who").addEventListener("submit", begin);
  $("challenge").addEventListener("click", () => {
    $("challenge").dataset.asked = "yes";
    $("challenge").disabled = true;
    socket.send(JSON.stringify({ do: "challenge" }));
  });
  $("end").addEventListener("click", () => {
    running = false;
    asked("Judging …");
    socket.send(JSON.stringify({ do: "end" }));
  });
  $("again").addEventListener("click", () => {
    $("result").hidden = true;
    $("who").hidden = false;
    $("claim").focus();
  });
  addEventListener("pagehide", () => { if (socket) socket.close(); });
})();
