// Fringes of one row over time: measured in each picture, and as the law predicts them from where the camera is.
//
// Convention: phases in fringe widths (turns), positive where the fringes are ahead; they fall with the parallax.  The law's
// gain is fitted, as the focal length is a usual one, and its constant in each stretch in which the badge is followed.
// Source: the law of `verifier/fringes/strip_law.py`, to first order.

/** Frequencies that are tried; least fringes within the row. */
const TRIED = 49, LEAST_FRINGES = 1;
/** Longest time between two pictures of one stretch, s; a row is kept of so many pictures. */
const LONGEST_S = 0.35, MOST_PICTURES = 4000;
/** The parallax is the mean of so many pictures before and after. */
const AROUND = 2;
/** How far the gain may be from the usual focal length's. */
const GAINS = [0.5, 2];

export class FringeTrace {
  #row; #waves; #best = 0; #power; #pictures = [];

  /** `row`: as in the studio's geometry. */
  constructor(row) {
    this.#row = row;
    const { samples, step_mm: step } = row, [low, high] = row.band_per_mm, length = samples * step;
    const every = Array.from({ length: TRIED }, (_, k) => low + ((high - low) * k) / (TRIED - 1));
    const fine = every.filter((frequency) => Math.abs(frequency) * length >= LEAST_FRINGES);
    this.#waves = (fine.length ? fine : [low]).map((frequency) => Array.from({ length: samples }, (_, k) => {
      const turns = 2 * Math.PI * frequency * (k - (samples - 1) / 2) * step;
      const window = 0.5 - 0.5 * Math.cos((2 * Math.PI * (k + 0.5)) / samples);
      return [window * Math.cos(turns), -window * Math.sin(turns)];
    }));
    this.#power = this.#waves.map(() => 0);
  }

  /** Adds a picture: its time, s, light along the row, and the parallax there. */
  add(time, profile, parallax) {
    if (this.#pictures.length >= MOST_PICTURES) return;
    const level = withoutSlope(profile), fringes = this.#waves.map((wave) => along(level, wave));
    fringes.forEach(([a, b], k) => { this.#power[k] += a * a + b * b; });
    this.#best = this.#power.indexOf(Math.max(...this.#power));
    this.#pictures.push({ time, parallax, fringes });
  }

  /** Begins anew, as where a film is played once more. */
  clear() { this.#pictures = []; this.#power.fill(0); }

  /** For each picture {time, seen, law}; null between two stretches. */
  lines() {
    const stretches = this.#stretches(), slope = -this.#row.slope_rad / (2 * Math.PI);
    let product = 0, square = 0;
    for (const stretch of stretches) {
      const [parallax, seen] = ["parallax", "seen"].map((name) => mean(stretch, name));
      stretch.forEach((one) => {
        product += (one.parallax - parallax) * (one.seen - seen);
        square += (one.parallax - parallax) ** 2;
      });
    }
    const gain = square > 0 ? Math.min(Math.max(product / square / slope, GAINS[0]), GAINS[1]) : 1;
    return stretches.flatMap((stretch, k) => {
      const [parallax, seen] = ["parallax", "seen"].map((name) => mean(stretch, name));
      const law = (one) => seen + gain * slope * (one.parallax - parallax);
      const drawn = stretch.map((one) => ({ time: one.time, seen: one.seen, law: law(one) }));
      return k ? [null, ...drawn] : drawn;
    });
  }

  /** The pictures with their phases, joined to whole turns within each stretch. */
  #stretches() {
    const stretches = [];
    let before = null;
    for (const { time, parallax, fringes } of this.#pictures) {
      const [a, b] = fringes[this.#best], seen = Math.atan2(b, a) / (2 * Math.PI);
      const goes = before !== null && time - before.time <= LONGEST_S;
      if (!goes) stretches.push([]);
      before = { time, parallax, seen: goes ? seen + Math.round(before.seen - seen) : seen };
      stretches.at(-1).push(before);
    }
    const near = (stretch, k) => stretch.slice(Math.max(k - AROUND, 0), k + AROUND + 1);
    return stretches.map((stretch) => stretch.map((one, k) => ({ ...one, parallax: mean(near(stretch, k), "parallax") })));
  }
}

const mean = (stretch, name) => stretch.reduce((sum, one) => sum + one[name], 0) / stretch.length;

/** The product of a row with a wave, as a complex number. */
function along(level, wave) {
  let a = 0, b = 0;
  for (let k = 0; k < level.length; k++) { a += level[k] * wave[k][0]; b += level[k] * wave[k][1]; }
  return [a, b];
}

/** The row without its mean and its slope. */
function withoutSlope(profile) {
  const count = profile.length, middle = (count - 1) / 2;
  let sum = 0, product = 0, square = 0;
  for (let k = 0; k < count; k++) { sum += profile[k]; product += (k - middle) * profile[k]; square += (k - middle) ** 2; }
  return profile.map((value, k) => value - sum / count - (product / square) * (k - middle));
}
