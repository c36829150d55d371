// A badge whose fringes follow the phase law: interpolated in the tables that `moireid_studio.pages.preview_law` traced.
//
// Convention: that of the server's module.  Page mm, x right, y down; a camera {x, y, z} has z < 0 and sees the page's
// point X along the tangents (X - C) / |z|.  `law` is the server's JSON.  Cells lie in their grating's own frame: first
// along its axis, then along its lines.

/** Pixels to the millimetre of the drawing. */
const PX_PER_MM = 4;
/** Where lines bend there are many rows, each with so many. */
const BENT_PX_PER_MM = 2;
const INK = 28, PAPER = 250;

/** The camera that looks at the board's middle from the tangents `right` and `down`, `distance` mm away. */
export function cameraAt(law, right, down, distance) {
  const [x0, y0, x1, y1] = law.board_mm;
  return { x: (x0 + x1) / 2 + right * distance, y: (y0 + y1) / 2 + down * distance, z: -distance };
}

/** A value of a grating's table, linearly interpolated; the table is symmetric in the tangent across. */
function lookUp(grating, table, along, across) {
  const rows = table.length, columns = table[0].length;
  const r = Math.min(Math.max((along - grating.first) / grating.step_along, 0), rows - 1);
  const c = Math.min(Math.abs(across) / grating.step_across, columns - 1);
  const r0 = Math.min(Math.floor(r), rows - 2), c0 = Math.min(Math.floor(c), columns - 2);
  const top = table[r0][c0] + (c - c0) * (table[r0][c0 + 1] - table[r0][c0]);
  const bottom = table[r0 + 1][c0] + (c - c0) * (table[r0 + 1][c0 + 1] - table[r0 + 1][c0]);
  return top + (r - r0) * (bottom - top);
}

/** A vector of the page in a grating's own frame; with `origin` 1 a place. */
function inOwn(grating, x, y, origin) {
  return grating.own.map(([a, b, at]) => a * x + b * y + origin * at);
}

/** A place of a grating's own frame on the page. */
function onPage(grating, first, second) {
  const [[a, b, at], [c, d, other]] = grating.own;
  return [a * (first - at) + c * (second - other), b * (first - at) + d * (second - other)];
}

/** By how many turns bent lines are ahead of a row's own pitch at a place along it, linearly interpolated. */
function aheadAt({ ahead, rect_mm: [low, , high] }, place) {
  if (!ahead) return 0;
  const at = Math.min(Math.max((place - low) / (high - low), 0), 1) * (ahead.length - 1);
  const from = Math.min(Math.floor(at), ahead.length - 2);
  return ahead[from] + (at - from) * (ahead[from + 1] - ahead[from]);
}

/** The place within a printed period that is seen at a point of the page, in turns, not wrapped. */
export function turnsAt(law, g, cell, x, y, camera) {
  const grating = law.gratings[g], { pitch_mm: printed, edge_mm: edge } = grating.cells[cell];
  const depth = Math.abs(camera.z), [place] = inOwn(grating, x, y, 1);
  const [along, across] = inOwn(grating, (x - camera.x) / depth, (y - camera.y) / depth, 0);
  const shift = lookUp(grating, grating.shift_mm, along, across);
  // The markers lie on the page and the fringes on the lenses, one thickness nearer.
  const lens = place - law.lens.thickness_mm * along - grating.middle_mm;
  const bent = aheadAt(grating.cells[cell], lens + grating.middle_mm);
  return bent + (grating.middle_mm - edge) / printed + lens * (1 / printed - 1 / law.lens.pitch_mm) + shift / printed;
}

/** How far the fringes in the middle of a grating's first cell have moved since the camera was straight ahead, mm. */
export function movedMm(law, g, camera) {
  const grating = law.gratings[g], [low, top, high, bottom] = grating.cells[0].rect_mm;
  const first = (low + high) / 2, second = (top + bottom) / 2, step = 0.5;
  const ahead = cameraAt(law, 0, 0, Math.abs(camera.z)), [x, y] = onPage(grating, first, second);
  const here = turnsAt(law, g, 0, x, y, ahead);
  const slope = (turnsAt(law, g, 0, ...onPage(grating, first + step, second), ahead) - here) / step;
  return (here - turnsAt(law, g, 0, x, y, camera)) / slope;
}

/** Brightness, 0 to 1, along the middle of a cell, `count` samples from its lesser end. */
export function brightness(law, g, cell, camera, count) {
  const grating = law.gratings[g], [low, top, high, bottom] = grating.cells[cell].rect_mm;
  const profile = grating.profile, places = profile.length;
  const mean = profile.reduce((sum, value) => sum + value, 0) / places;
  const out = new Float32Array(count);
  for (let k = 0; k < count; k++) {
    const [x, y] = onPage(grating, low + (k + 0.5) / count * (high - low), (top + bottom) / 2);
    const depth = Math.abs(camera.z);
    const kept = lookUp(grating, grating.contrast, ...inOwn(grating, (x - camera.x) / depth, (y - camera.y) / depth, 0));
    const turns = turnsAt(law, g, cell, x, y, camera), at = (turns - Math.floor(turns)) * places, from = Math.floor(at);
    const value = profile[from % places] + (at - from) * (profile[(from + 1) % places] - profile[from % places]);
    out[k] = mean + kept * (value - mean);
  }
  return out;
}

/** Draws a badge on a canvas; what never moves is drawn once. */
export class BadgePicture {
  constructor(canvas, law) {
    this.law = law;
    const [x0, y0, x1, y1] = law.board_mm;
    canvas.width = Math.round((x1 - x0) * PX_PER_MM);
    canvas.height = Math.round((y1 - y0) * PX_PER_MM);
    this.context = canvas.getContext("2d");
    this.rows = document.createElement("canvas").getContext("2d");
    this.fixed();
    if (law.worn) this.wear(law.worn);
  }

  /** The picture of all that the badge wears, in the place of markers and words, as soon as it is loaded. */
  wear(address) {
    const worn = new Image();
    worn.addEventListener("load", () => {
      this.context.drawImage(worn, 0, 0, this.context.canvas.width, this.context.canvas.height);
      if (this.camera) this.draw(this.camera);
    });
    worn.src = address;
  }

  /** A rectangle of the page in whole pixels: left, top, width, height. */
  pixels(rect) {
    const [left, top, right, bottom] = rect.map((value, k) => Math.round((value - this.law.board_mm[k % 2]) * PX_PER_MM));
    return [left, top, right - left, bottom - top];
  }

  /** Paper, markers and words. */
  fixed() {
    const pen = this.context, grey = (level) => `rgb(${level},${level},${level})`;
    pen.fillStyle = grey(PAPER);
    pen.fillRect(0, 0, pen.canvas.width, pen.canvas.height);
    for (const { black, white } of this.law.markers) {
      pen.fillStyle = grey(INK);
      pen.fillRect(...this.pixels(black));
      pen.fillStyle = grey(PAPER);
      for (const rect of white) pen.fillRect(...this.pixels(rect));
    }
    pen.fillStyle = grey(INK);
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    for (const { text, box_mm: box, height_mm: height } of this.law.words) {
      const [left, top, width, room] = this.pixels(box);
      pen.font = `600 ${height * PX_PER_MM}px system-ui, sans-serif`;
      const lines = broken(pen, text, width);
      const step = Math.min(height * PX_PER_MM * 1.25, room / lines.length);
      pen.font = `600 ${step / 1.25}px system-ui, sans-serif`;
      lines.forEach((line, k) => pen.fillText(line, left + width / 2, top + room / 2 + (k - (lines.length - 1) / 2) * step, width));
    }
  }

  /** The fringes as `camera` sees them; rows whose lines bend are one picture, so that no step is seen between them. */
  draw(camera) {
    this.camera = camera;
    this.law.gratings.forEach((grating, g) => {
      const numbers = [...grating.cells.keys()];
      for (const rows of grating.bent ? [numbers] : numbers.map((c) => [c])) this.paint(g, rows, camera);
    });
  }

  /** Cells of one grating that lie below each other, as a picture with a row of pixels for each. */
  paint(g, rows, camera) {
    const grating = this.law.gratings[g];
    const [low, top, high] = grating.cells[rows[0]].rect_mm, bottom = grating.cells[rows.at(-1)].rect_mm[3];
    const count = Math.ceil((high - low) * (grating.bent ? BENT_PX_PER_MM : PX_PER_MM));
    this.rows.canvas.width = count;
    this.rows.canvas.height = rows.length;
    const image = this.rows.createImageData(count, rows.length), data = image.data;
    let k = 0;
    for (const row of rows) {
      for (const light of brightness(this.law, g, row, camera, count)) {
        data[k] = data[k + 1] = data[k + 2] = INK + (PAPER - INK) * light;
        data[k + 3] = 255;
        k += 4;
      }
    }
    this.rows.putImageData(image, 0, 0);
    // The picture's rows are placed along the grating's axis and stretched along its lines.
    const [[a, b], [d, e]] = grating.own, [x, y] = onPage(grating, low, top), [x0, y0] = this.law.board_mm;
    const across = (high - low) / count * PX_PER_MM, down = (bottom - top) / rows.length * PX_PER_MM;
    const pen = this.context;
    pen.setTransform(a * across, b * across, d * down, e * down, (x - x0) * PX_PER_MM, (y - y0) * PX_PER_MM);
    // Half a pixel over, so that neighbours leave no seam.
    pen.drawImage(this.rows.canvas, 0, 0, count + 0.5 / across, rows.length + 0.5 / down);
    pen.resetTransform();
  }
}

/** Words in at most four lines no wider than `width`; a longer word is squeezed by the caller. */
function broken(pen, text, width) {
  const lines = [""];
  for (const word of text.split(/\s+/)) {
    const longer = lines.at(-1) ? `${lines.at(-1)} ${word}` : word;
    if (pen.measureText(longer).width <= width || !lines.at(-1) || lines.length === 4) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}
