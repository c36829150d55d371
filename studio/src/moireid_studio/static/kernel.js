// The verifier's kernel in WebAssembly: registers the printed page on a picture, and reads a row of it.
//
// Convention: structs as in kernel.h, with pointers of four bytes.  A warp, nine numbers row by row,
// leads from places of the page, in units of the squares' extent about their middle, to px of the picture.

const PAGE_BYTES = 65536;
const PICTURE_BYTES = 24, PLACES_BYTES = 96, PRINT_BYTES = 152, RULES_BYTES = 64, COMPARISON_BYTES = 344;
/** How many of the rules are whole numbers; they come first. */
const WHOLE_RULES = 4;

/** What a byte of brightness means: counts, 0 to 255, and light, as in the verifier's `video.py` and `picture.py`. */
export function levelsOf(fullRange) {
  const count = (byte) => Math.min(Math.max(Math.round(((byte - 16) * 255) / 219), 0), 255);
  const counts = Float32Array.from({ length: 256 }, (_, byte) => (fullRange ? byte : count(byte)));
  return { counts, light: counts.map((value) => 255 * (value / 255) ** 2.2) };
}

/** The compiled kernel.  Throws where the browser cannot compile it. */
export async function loadKernel() {
  return WebAssembly.compileStreaming(fetch("/static/kernel.wasm"));
}

/** One kernel with memory of its own, which grows with what is put there and goes with the kernel. */
export class PageKernel {
  #calls; #end; #rules; #found; #counts; #light;

  /** `rules`: of the registration, as the studio gives them. */
  constructor(compiled, rules) {
    this.#calls = new WebAssembly.Instance(compiled).exports;
    this.#end = this.#calls.__heap_base.value;
    this.#rules = this.#take(RULES_BYTES);
    this.#found = this.#take(COMPARISON_BYTES);
    this.#counts = this.#take(PICTURE_BYTES);
    this.#light = this.#take(PICTURE_BYTES);
    rules.forEach((value, k) => {
      if (k < WHOLE_RULES) this.#memory.setInt32(this.#rules + 4 * k, value, true);
      else this.#memory.setFloat64(this.#rules + 4 * WHOLE_RULES + 8 * (k - WHOLE_RULES), value, true);
    });
  }

  get #buffer() { return this.#calls.memory.buffer; }
  get #memory() { return new DataView(this.#buffer); }

  /** The address of so many bytes. */
  #take(bytes) {
    const at = (this.#end + 15) & ~15;
    this.#end = at + bytes;
    const lack = this.#end - this.#buffer.byteLength;
    if (lack > 0) this.#calls.memory.grow(Math.ceil(lack / PAGE_BYTES));
    return at;
  }

  /** The address of a copy of some numbers of a kind. */
  #put(Kind, values) {
    const at = this.#take(values.length * Kind.BYTES_PER_ELEMENT);
    new Kind(this.#buffer, at, values.length).set(values);
    return at;
  }

  /** Room for a picture's bytes, its rows `stride` bytes apart from `offset` on; `counts` and `light`: what each byte means. */
  preparePicture({ width, height, stride, offset, bytes, counts, light }) {
    const plane = this.#take(bytes);
    for (const [at, levels] of [[this.#counts, counts], [this.#light, light]]) {
      const values = this.#put(Float32Array, levels), memory = this.#memory;
      memory.setUint32(at, plane + offset, true);
      memory.setUint32(at + 4, values, true);
      memory.setBigInt64(at + 8, BigInt(stride), true);
      memory.setInt32(at + 16, width, true);
      memory.setInt32(at + 20, height, true);
    }
    return { plane, bytes };
  }

  /** The bytes of that room; asked for anew each time, as memory that grows moves. */
  pictureBytes({ plane, bytes }) { return new Uint8Array(this.#buffer, plane, bytes); }

  /** Writes the places x, y (N) as a struct. */
  #writePlaces(at, x, y) {
    const low = [x, y].map((values) => values.reduce((a, b) => Math.min(a, b)));
    const high = [x, y].map((values) => values.reduce((a, b) => Math.max(a, b)));
    const middle = low.map((value, k) => (value + high[k]) / 2);
    const places = [x, y].map((values, k) => this.#put(Float32Array, Float64Array.from(values, (value) => value - middle[k])));
    const memory = this.#memory;
    places.forEach((place, k) => memory.setUint32(at + 4 * k, place, true));
    const hull = [low[0], low[1], high[0], low[1], high[0], high[1], low[0], high[1]];
    [...middle, ...hull].forEach((value, k) => memory.setFloat64(at + 8 + 8 * k, value, true));
    memory.setInt32(at + 88, x.length, true);
  }

  /**
   * A print to register with.  `samples` (5 N): x, y, brightness and its gradient, as the studio gives them for `patches`
   * squares; `pxPerUnit`: its scale; the rest as in the studio's geometry.
   */
  preparePrint(samples, patches, pxPerUnit, { least_seen, most_squares, least_correlation }) {
    const count = samples.length / 5, each = count / patches, part = (k) => samples.subarray(k * count, (k + 1) * count);
    const at = this.#take(PRINT_BYTES), printed = part(2);
    this.#writePlaces(at, part(0), part(1));
    const power = Array.from({ length: patches }, (_, k) =>
      printed.subarray(k * each, (k + 1) * each).reduce((sum, value) => sum + value * value, 0));
    const first = this.#put(Int32Array, Array.from({ length: patches + 1 }, (_, k) => k * each));
    const side = this.#put(Int32Array, new Array(patches).fill(-1));
    const values = this.#put(Float32Array, printed), powers = this.#put(Float64Array, power);
    const gradient = this.#put(Float32Array, samples.subarray(3 * count)), free = this.#take(32 * count);
    const normal = this.#take(512 * patches);
    const room = this.#take(4 * count), warp = this.#take(72);
    const memory = this.#memory;
    [patches, least_seen, most_squares, first, side, values, free, powers, normal].forEach(
      (value, k) => memory.setInt32(at + PLACES_BYTES + 4 * k, value, true));
    memory.setFloat64(at + 136, pxPerUnit, true);
    memory.setFloat64(at + 144, least_correlation, true);
    this.#calls.kernel_free(at, gradient, free, normal);
    return { at, room, warp };
  }

  /** The warp that fits the picture, from one nearby; null where the page does not match or too few squares are seen. */
  register(print, start, leastCorrelation) {
    new Float64Array(this.#buffer, print.warp, 9).set(start);
    const state = this.#calls.kernel_register(this.#counts, print.at, this.#rules, print.warp, print.room, this.#found);
    const warp = Array.from(new Float64Array(this.#buffer, print.warp, 9));
    const fits = state === 1 && this.#memory.getFloat64(this.#found, true) >= leastCorrelation;
    return fits && warp.every(Number.isFinite) ? warp : null;
  }

  /** A row to read: places x, y (lines x samples), one line after another. */
  prepareRow(x, y, samples) {
    const at = this.#take(PLACES_BYTES);
    this.#writePlaces(at, x, y);
    const lines = this.#put(Int32Array, [x.length / samples]), warp = this.#take(72);
    return { at, samples, lines, warp, profile: this.#take(4 * samples) };
  }

  /** Light along a row, the mean of its lines (samples). */
  readRow(row, warp) {
    new Float64Array(this.#buffer, row.warp, 9).set(warp);
    this.#calls.kernel_rows(this.#light, row.at, row.warp, row.lines, 1, row.samples, row.profile);
    return Float32Array.from(new Float32Array(this.#buffer, row.profile, row.samples));
  }
}
