// A check by pictures: a socket, pictures out, events in.  Pictures that cannot be sent in time are dropped, never queued.
const QUALITY = 0.85, MOST_AHEAD = 5, MOST_WAIT_MS = 250, MOST_CODING_MS = 150, MOST_BUFFERED = 1 << 20, RATE_MS = 2000;
export const LEAST_MS = 28;
// Where pictures queue for longer than this, fewer are sent, evenly: down to 12 a second, between which motion is still
// followed.  Five in a burst and then none for half a second would leave a gap.
const QUEUED_MS = 80, MOST_GAP_MS = 80, SLOWER = 1.3, FASTER = 0.98;
// Pictures a second that are wanted, and the time (ms) that there is for one of them.
const WANTED = 24, MOST_MS = 1000 / WANTED;
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / Math.max(values.length, 1);
const bytesOf = (address) => Uint8Array.from(atob(address.slice(address.indexOf(",") + 1)), (letter) => letter.charCodeAt(0));

export class Check {
  /** path: of the socket; hello: what is asked; on: functions by the names of events, and `lost`. */
  constructor(path, hello, on) {
    Object.assign(this, { on, sent: 0, taken: 0, last: -Infinity, over: false, starved: false, counted: [], away: [] });
    Object.assign(this, { gap: LEAST_MS, soonest: Infinity, coding: [] });
    this.socket = new WebSocket((location.protocol === "https:" ? "wss://" : "ws://") + location.host + path);
    this.socket.onopen = () => this.request(hello);
    this.socket.onmessage = (message) => this.receive(JSON.parse(message.data));
    this.socket.onclose = () => {
      if (this.over) return;
      this.over = true;
      on.lost("The connection was lost, or you may not use this; begin again.");
    };
    addEventListener("pagehide", () => this.socket.close());
  }

  receive(event) {
    if (event.event === "taken") {
      this.taken = event.frames;
      const at = performance.now(), took = at - this.away.shift();
      this.pace(took);
      this.counted.push({ at, took, judging: event.judging_ms });
    }
    if (event.event === "verdict" || event.event === "error") this.over = true;
    (this.on[event.event] || (() => {}))(event);
  }

  /** The time between two pictures (ms) follows how much longer than the soonest one a picture took to be judged. */
  pace(took) {
    this.soonest = Math.min(this.soonest, took);
    if (took - this.soonest > QUEUED_MS) this.gap = Math.min(this.gap * SLOWER, MOST_GAP_MS);
    else this.gap = Math.max(this.gap * FASTER, LEAST_MS);
  }

  request(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** Send what the canvas shows, taken at `time` (ms), if there is room on the way. */
  send(canvas, time) {
    if (this.over || time - this.last < this.gap || this.socket.readyState !== WebSocket.OPEN) return;
    if (this.sent - this.taken >= MOST_AHEAD || this.socket.bufferedAmount > MOST_BUFFERED) return;
    // A studio that is slow gets fewer pictures, and those in time.
    if (this.away.length && performance.now() - this.away[0] > MOST_WAIT_MS) return;
    this.last = time;
    this.sent += 1;
    this.away.push(performance.now());
    if (this.starved) {
      this.ship(bytesOf(canvas.toDataURL("image/jpeg", QUALITY)), time);
      return;
    }
    const begun = performance.now();
    canvas.toBlob((picture) => {
      // A browser codes pictures when it is idle, and in a page that it hardly draws it thinks of that once a second.
      const took = performance.now() - begun;
      this.starved = took > MOST_CODING_MS;
      this.coding = [...this.coding.slice(1 - WANTED), took];
      this.ship(picture, time);
    }, "image/jpeg", QUALITY);
  }

  ship(picture, time) {
    const clock = new DataView(new ArrayBuffer(8));
    clock.setFloat64(0, time);
    if (picture && this.socket.readyState === WebSocket.OPEN) this.socket.send(new Blob([clock.buffer, picture]));
    else {
      this.sent -= 1;
      this.away.pop();
    }
  }

  /** Pictures a second that were taken in the last seconds; null as long as that is not known. */
  rate() {
    const now = performance.now();
    if (!this.counted.length || now - this.counted[0].at < RATE_MS) return null;
    while (now - this.counted[0].at > 2 * RATE_MS) this.counted.shift();
    return this.counted.filter(({ at }) => now - at < RATE_MS).length * 1000 / RATE_MS;
  }

  /** Why fewer pictures are judged than were filmed, and what to do: from the times that each step took. */
  cause() {
    const judging = mean(this.counted.map((one) => one.judging)), coding = mean(this.coding);
    if (judging > MOST_MS) {
      return `Judging one takes ${Math.round(judging)} ms: the processor of the studio's machine is busy. Close other programs on it.`;
    }
    if (coding > MOST_MS) return `This device needs ${Math.round(coding)} ms to code one: its processor is busy. Close other programs.`;
    const way = Math.max(mean(this.counted.map((one) => one.took)) - judging, 0);
    if (way < QUEUED_MS) {
      return `One is judged in ${Math.round(judging)} ms, and is ${Math.round(way)} ms on its way, so this device gives too few: its processor is busy. Close other programs.`;
    }
    return `One is judged in ${Math.round(judging)} ms, and is ${Math.round(way)} ms on its way: the connection is slow. Use a faster one.`;
  }

  close() {
    this.over = true;
    this.socket.close();
  }
}
