// Finds a page by its printed squares in one picture: dark blobs with corners, whose cells are a known square's.
//
// Convention: a picture is {bytes, width, height, stride, offset}; px from the middle of its first pixel.

import { fitHomography, mapped, scaleOf } from "./homography.js";

/** The longer side of the reduced picture, px; least side of a square there; how much darker than around is dark. */
const LONG_PX = 1000, LEAST_PX = 7, DARKER = 6;
/** Longest side of a square over its shortest, and how much of its area is dark, at least and most. */
const MOST_SLANT = 3, FILLED = [0.3, 1.6];
/** Half the window of what is around, as a share of the longer side. */
const AROUND = 1 / 24;
/** Cells that may be wrong within a square, and squares that must be seen. */
const WRONG_BORDER = 1, WRONG_CELLS = 1, LEAST_SQUARES = 3;
/** How far a corner may be from where the others say, as a share of the page's extent. */
const MOST_OFF = 0.06;

/** A part of the picture, each pixel the mean of `factor` x `factor`. */
function reduced({ bytes, stride, offset }, { left, top, width, height }, factor) {
  const wide = Math.floor(width / factor), high = Math.floor(height / factor), small = new Float32Array(wide * high);
  for (let y = 0; y < high * factor; y++) {
    const to = Math.floor(y / factor) * wide;
    let from = offset + (top + y) * stride + left;
    for (let x = to; x < to + wide; x++) for (let k = 0; k < factor; k++) small[x] += bytes[from++];
  }
  for (let k = 0; k < small.length; k++) small[k] /= factor * factor;
  return { small, wide, high };
}

/** 1 where a pixel is darker than the mean of what is around it. */
function darkPixels({ small, wide, high }) {
  const sums = new Float64Array((wide + 1) * (high + 1)), dark = new Uint8Array(wide * high);
  for (let y = 0; y < high; y++) {
    let line = 0;
    for (let x = 0; x < wide; x++) {
      line += small[y * wide + x];
      sums[(y + 1) * (wide + 1) + x + 1] = sums[y * (wide + 1) + x + 1] + line;
    }
  }
  const half = Math.ceil(Math.max(wide, high) * AROUND);
  for (let y = 0; y < high; y++) {
    const top = Math.max(y - half, 0) * (wide + 1), bottom = Math.min(y + half + 1, high) * (wide + 1);
    const lines = (bottom - top) / (wide + 1);
    for (let x = 0; x < wide; x++) {
      const left = Math.max(x - half, 0), right = Math.min(x + half + 1, wide);
      const sum = sums[bottom + right] - sums[bottom + left] - sums[top + right] + sums[top + left];
      dark[y * wide + x] = small[y * wide + x] + DARKER < sum / (lines * (right - left)) ? 1 : 0;
    }
  }
  return dark;
}

/** The connected dark pixels from one on, as their numbers; they are dark no longer. */
function blobFrom(start, dark, wide) {
  const blob = [start];
  dark[start] = 0;
  const take = (at) => { if (dark[at]) { dark[at] = 0; blob.push(at); } };
  for (let k = 0; k < blob.length; k++) {
    const at = blob[k], x = at % wide;
    if (x > 0) take(at - 1);
    if (x < wide - 1) take(at + 1);
    take(at - wide);
    take(at + wide);
  }
  return blob;
}

const apart = (a, b) => (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2;

/** The point for which a figure is greatest. */
function farthest(points, figure) {
  let best = points[0], most = -Infinity;
  for (const point of points) {
    const value = figure(point);
    if (value > most) [best, most] = [point, value];
  }
  return best;
}

/** The corners of a blob, clockwise; null where it is no square seen from anywhere. */
function cornersOf(blob, wide) {
  const points = blob.map((at) => [at % wide, Math.floor(at / wide)]);
  const middle = [0, 1].map((k) => points.reduce((sum, point) => sum + point[k], 0) / points.length);
  const a = farthest(points, (point) => apart(point, middle)), c = farthest(points, (point) => apart(point, a));
  const side = (point) => (c[0] - a[0]) * (point[1] - a[1]) - (c[1] - a[1]) * (point[0] - a[0]);
  const b = farthest(points, (point) => -side(point)), d = farthest(points, side);
  const corners = [a, b, c, d], sides = corners.map((corner, k) => Math.sqrt(apart(corner, corners[(k + 1) % 4])));
  const area = (side(d) - side(b)) / 2, share = points.length / area;
  const [shortest, longest] = [Math.min(...sides), Math.max(...sides)];
  if (!(shortest >= LEAST_PX - 1 && longest < MOST_SLANT * shortest && share > FILLED[0] && share < FILLED[1])) return null;
  // Pixels at the rim are half within.
  const centre = [0, 1].map((k) => corners.reduce((sum, corner) => sum + corner[k], 0) / 4);
  return corners.map((corner) => corner.map((value, k) => value + (0.7 * (value - centre[k])) / Math.sqrt(apart(centre, corner))));
}

/** Brightness at a place, bilinear; the border's beyond it. */
function brightness({ bytes, width, height, stride, offset }, [x, y]) {
  const u = Math.min(Math.max(x, 0), width - 1.001), v = Math.min(Math.max(y, 0), height - 1.001);
  const left = Math.floor(u), top = Math.floor(v), at = offset + top * stride + left, a = u - left, b = v - top;
  return (1 - b) * ((1 - a) * bytes[at] + a * bytes[at + 1]) + b * ((1 - a) * bytes[at + stride] + a * bytes[at + stride + 1]);
}

const UNIT_SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]];

/** Whether each cell within these corners is white, row by row. */
function cellsWithin(picture, corners, side) {
  const h = fitHomography(UNIT_SQUARE, corners), values = [];
  if (!h) return [];
  for (let row = 0; row < side; row++) for (let column = 0; column < side; column++) {
    values.push(brightness(picture, mapped(h, (column + 0.5) / side, (row + 0.5) / side)));
  }
  const limit = (Math.min(...values) + Math.max(...values)) / 2;
  return values.map((value) => (value > limit ? 1 : 0));
}

/** Which known square, and by how many quarter turns: {square, turns}; null where none. */
function squareOf(cells, known) {
  const side = Math.sqrt(cells.length), inner = (k) => [k % side, Math.floor(k / side)].every((n) => n > 0 && n < side - 1);
  if (cells.filter((cell, k) => cell && !inner(k)).length > WRONG_BORDER) return null;
  for (let square = 0; square < known.length; square++) {
    let turned = cells;
    for (let turns = 0; turns < 4; turns++) {
      if (turned.filter((cell, k) => inner(k) && cell !== known[square][k]).length <= WRONG_CELLS) return { square, turns };
      // A quarter turn back: the first row is what was the last column.
      turned = turned.map((_, k) => turned[(k % side) * side + side - 1 - Math.floor(k / side)]);
    }
  }
  return null;
}

/** The page's places of a square's corners, as in its geometry. */
function cornerPlaces({ middle_mm, extent_mm, squares }, square) {
  const half = squares.size_mm / 2, [x, y] = squares.centers_mm[square];
  const place = (centre, k, share) => (centre - middle_mm[k] + (2 * share - 1) * half) / extent_mm;
  return UNIT_SQUARE.map(([a, b]) => [place(x, 0, a), place(y, 1, b)]);
}

/**
 * The homography page -> px of the badge whose `geometry` this is, from a part of the picture, `box`: {left, top, width,
 * height}; null where too few of its squares are seen.
 */
export function findPage(picture, box, geometry) {
  const factor = Math.max(1, Math.round(Math.max(box.width, box.height) / LONG_PX));
  const small = reduced(picture, box, factor), dark = darkPixels(small), { cells: known } = geometry.squares;
  const side = Math.sqrt(known[0].length), corner = [box.left, box.top], places = [], points = [], seen = new Set();
  for (let at = 0; at < dark.length; at++) {
    if (!dark[at]) continue;
    const blob = blobFrom(at, dark, small.wide);
    const corners = blob.length >= (LEAST_PX * LEAST_PX) / 2 ? cornersOf(blob, small.wide) : null;
    if (!corners) continue;
    const whole = corners.map((point) => point.map((value, k) => (value + 0.5) * factor - 0.5 + corner[k]));
    const found = squareOf(cellsWithin(picture, whole, side), known);
    if (!found || seen.has(found.square)) continue;
    seen.add(found.square);
    places.push(...cornerPlaces(geometry, found.square));
    points.push(...whole.map((_, k) => whole[(k + found.turns) % 4]));
  }
  const page = seen.size >= LEAST_SQUARES ? fitHomography(places, points) : null;
  if (!page) return null;
  const most = MOST_OFF * scaleOf(page);
  const agree = places.every((place, k) => apart(mapped(page, ...place), points[k]) < most ** 2);
  return agree ? page : null;
}
