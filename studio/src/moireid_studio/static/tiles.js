// Finds the tiles of a call in a picture of its window: boxes that its plain background surrounds.
//
// A call's program paints its background in one flat colour; a camera's picture is never so flat.  So the commonest flat
// colour is taken for the background, and a tile is a box of other pixels that it fills.  Where there is none, the whole
// picture is the one tile.  Boxes are {x, y, w, h}, in px of the picture that is given.
const FLAT = 2, SAME = 6, LEAST_SHARE = 0.1, LEAST_FILL = 0.8, ASPECT = [0.45, 2.6], STEP = 8;
//: A box is still the same where each side has moved by less than this share of its width.
const STAYS = 0.03;

export function findTiles(picture) {
  const { width, height } = picture, whole = { x: 0, y: 0, w: width, h: height };
  const background = commonestFlat(picture);
  if (background === null) return [whole];
  const mark = new Uint8Array(width * height);
  for (let at = 0; at < mark.length; at++) mark[at] = near(picture.data, 4 * at, background, SAME) ? 0 : 1;
  const found = boxesOf(mark, width, height).filter((box) => {
    const aspect = box.w / box.h;
    return box.w >= LEAST_SHARE * width && box.fill >= LEAST_FILL && aspect > ASPECT[0] && aspect < ASPECT[1];
  });
  return found.length ? found.map(({ x, y, w, h }) => ({ x, y, w, h })) : [whole];
}

/** Whether one of the tiles is still where the box is. */
export function stillThere(tiles, box) {
  const most = Math.max(STAYS * box.w, 4);
  return tiles.some((one) => [one.x - box.x, one.y - box.y, one.x + one.w - box.x - box.w, one.y + one.h - box.y - box.h]
    .every((gone) => Math.abs(gone) <= most));
}

/** The tile that differs most between two pictures. */
export function movingTile(tiles, before, after) {
  const moved = tiles.map((box) => {
    let sum = 0, count = 0;
    for (let y = box.y; y < box.y + box.h; y += 3) {
      for (let x = box.x; x < box.x + box.w; x += 3) {
        const at = 4 * (y * after.width + x) + 1;
        sum += Math.abs(after.data[at] - before.data[at]);
        count += 1;
      }
    }
    return sum / count;
  });
  return tiles[moved.indexOf(Math.max(...moved))];
}

function near(data, at, colour, most) {
  return Math.abs(data[at] - colour[0]) <= most && Math.abs(data[at + 1] - colour[1]) <= most
    && Math.abs(data[at + 2] - colour[2]) <= most;
}

// The colour that most small flat squares have; null where hardly any is flat.
function commonestFlat({ data, width, height }) {
  const counts = new Map();
  let squares = 0;
  for (let y = 0; y + STEP <= height; y += STEP) {
    for (let x = 0; x + STEP <= width; x += STEP) {
      squares += 1;
      const at = 4 * (y * width + x), colour = [data[at], data[at + 1], data[at + 2]];
      let flat = true;
      for (let k = 0; flat && k < STEP; k++) {
        flat = near(data, 4 * ((y + k) * width + x + k), colour, FLAT) && near(data, 4 * ((y + k) * width + x + STEP - 1 - k), colour, FLAT);
      }
      if (!flat) continue;
      const key = colour.map((part) => part >> 2).join();
      const seen = counts.get(key) || { count: 0, colour };
      seen.count += 1;
      counts.set(key, seen);
    }
  }
  const most = [...counts.values()].reduce((best, one) => (one.count > best.count ? one : best), { count: 0 });
  return most.count > 0.01 * squares ? most.colour : null;
}

// Boxes of connected marked pixels, the largest first, with the share of each box that is marked.
function boxesOf(mark, width, height) {
  const found = [], stack = [];
  for (let start = 0; start < mark.length; start++) {
    if (mark[start] !== 1) continue;
    let left = width, right = 0, top = height, bottom = 0, count = 0;
    stack.push(start);
    mark[start] = 2;
    while (stack.length) {
      const at = stack.pop(), x = at % width, y = (at - x) / width;
      count += 1;
      left = Math.min(left, x); right = Math.max(right, x); top = Math.min(top, y); bottom = Math.max(bottom, y);
      for (const next of [x > 0 ? at - 1 : -1, x < width - 1 ? at + 1 : -1, at - width, at + width]) {
        if (next >= 0 && next < mark.length && mark[next] === 1) { mark[next] = 2; stack.push(next); }
      }
    }
    const box = { x: left, y: top, w: right - left + 1, h: bottom - top + 1 };
    found.push({ ...box, fill: count / (box.w * box.h) });
  }
  return found.sort((a, b) => b.w * b.h - a.w * a.h);
}
