// Homographies: fitted to points, applied, and the camera's place that one of them means.
//
// Convention: nine numbers row by row, the last one 1, from places of the page to px.

/** Where a place is in the picture. */
export function mapped(h, x, y) {
  const w = h[6] * x + h[7] * y + h[8];
  return [(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w];
}

/** Solves A x = b by elimination, in place; null where it has no one solution. */
function solve(a, b) {
  const size = b.length;
  for (let k = 0; k < size; k++) {
    let best = k;
    for (let row = k + 1; row < size; row++) if (Math.abs(a[row][k]) > Math.abs(a[best][k])) best = row;
    if (!(Math.abs(a[best][k]) > 1e-12)) return null;
    [a[k], a[best], b[k], b[best]] = [a[best], a[k], b[best], b[k]];
    for (let row = k + 1; row < size; row++) {
      const share = a[row][k] / a[k][k];
      for (let column = k; column < size; column++) a[row][column] -= share * a[k][column];
      b[row] -= share * b[k];
    }
  }
  for (let k = size - 1; k >= 0; k--) {
    for (let column = k + 1; column < size; column++) b[k] -= a[k][column] * b[column];
    b[k] /= a[k][k];
  }
  return b;
}

/** px are fitted in this unit, so that all unknowns are of about one. */
const UNIT_PX = 1000;

/** The homography that leads from `places` to `points`, four or more each; null where none does.  Source: the direct
 *  linear transform, by least squares. */
export function fitHomography(places, points) {
  const normal = Array.from({ length: 8 }, () => new Array(8).fill(0)), side = new Array(8).fill(0);
  places.forEach(([x, y], k) => {
    const [u, v] = points[k].map((value) => value / UNIT_PX);
    for (const [row, value] of [[[x, y, 1, 0, 0, 0, -x * u, -y * u], u], [[0, 0, 0, x, y, 1, -x * v, -y * v], v]]) {
      for (let i = 0; i < 8; i++) {
        side[i] += row[i] * value;
        for (let j = 0; j < 8; j++) normal[i][j] += row[i] * row[j];
      }
    }
  });
  const found = solve(normal, side);
  return found && [...found.map((value, k) => (k < 6 ? value * UNIT_PX : value)), 1];
}

/** px per unit of the places, about the place (0, 0). */
export function scaleOf(h) {
  const [a, b, c, d, e, f, g, i, w] = h;
  return Math.sqrt(Math.abs(a * (e * w - f * i) - b * (d * w - f * g) + c * (d * i - e * g)) / Math.abs(w) ** 3);
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((value) => value / Math.sqrt(dot(a, a)));

/** The camera's place, z < 0, in the unit of the places, for a focal length and the picture's middle in px. */
export function cameraPlace(h, focal, middle) {
  const column = (k) => [(h[k] - middle[0] * h[6 + k]) / focal, (h[3 + k] - middle[1] * h[6 + k]) / focal, h[6 + k]];
  const [x, y, t] = [column(0), column(1), column(2)];
  const long = 2 / (Math.sqrt(dot(x, x)) + Math.sqrt(dot(y, y)));
  // The nearest pair of directions at right angles: half of what lacks is taken from each.
  const [across, down] = [unit(x), unit(y)], sum = unit(across.map((value, k) => value + down[k]));
  const difference = unit(across.map((value, k) => value - down[k]));
  const first = sum.map((value, k) => (value + difference[k]) * Math.SQRT1_2);
  const second = sum.map((value, k) => (value - difference[k]) * Math.SQRT1_2);
  const third = [1, 2, 0].map((k, n) => first[k] * second[(n + 2) % 3] - first[(n + 2) % 3] * second[k]);
  const way = t.map((value) => -value * long);
  const place = [dot(first, way), dot(second, way), dot(third, way)];
  return place[2] < 0 ? place : place.map((value) => -value);
}
