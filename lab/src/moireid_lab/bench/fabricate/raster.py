"""The page as a raster paints it, and the badge read off that raster alone.

Poppler and Ghostscript are asked for one bit a dot, as a printer's own raster works: both paint every dot that is
touched.  "poppler-grey" greys dots that are covered in part, and half grey counts as dark.

The reader knows only what a verifier knows: places and roles of rows and cells, but no line's place or pitch.
Those are measured in the raster, cells against the reference row, and given to the ordinary decoder.
"""

from __future__ import annotations

import math
import shutil
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Cell, Grating
from moireid.errors import FabricationError
from moireid.idcodes import family_named
from moireid.idcodes.family import CellReading, DecodeResult
from moireid.layers import is_smooth
from moireid.sheets import MM_PER_INCH
from moireid.smooth_lines import rims_mm

Array = NDArray[np.float64]
RASTERS = ("poppler", "poppler-grey", "ghostscript")
#: Left out at a cell's ends, mm: lines there are cut, or belong to the neighbour.
MARGIN_MM = 0.6
#: Markers are sought on the page shrunk to about this, which is plenty for them and quick at any resolution.
MARKER_DPI = 150


@dataclass(frozen=True)
class Raster:
    """One page in dots: packed (H, ceil(W / 8)), 1 dark, which holds A4 at 4800 dpi in 280 MB."""

    packed: NDArray[np.uint8]
    width: int
    dpi: int

    @property
    def dot_mm(self) -> float:
        """Width of one dot, mm."""
        return MM_PER_INCH / self.dpi

    def line(self, axis: str, number: int) -> NDArray[np.uint8]:
        """Row `number` for axis x, column `number` for axis y; 1 where dark."""
        if axis == "x":
            return np.asarray(np.unpackbits(self.packed[number])[: self.width])
        return np.asarray(self.packed[:, number // 8] >> (7 - number % 8) & 1)

    def shrunk(self, times: int) -> NDArray[np.uint8]:
        """The page in grey, 0 black, each pixel the mean over `times` x `times` dots."""
        rows, columns = len(self.packed) // times, self.width // times
        grey = np.empty((rows, columns), np.uint8)
        for row in range(rows):
            dots = np.unpackbits(self.packed[row * times : (row + 1) * times], axis=1)[:, : columns * times]
            share = dots.sum(axis=0, dtype=np.int64).reshape(columns, times).sum(axis=1) / times**2
            grey[row] = np.round(255 * (1 - share))
        return grey


@dataclass(frozen=True)
class PageReading:
    """What is read from a raster of a badge whose lines are not known.

    found: the decoder's answer; markers: ids that were found; marker_error_mm: the largest distance of a marker's
    corner from its place; phase_error_rad: the largest distance of a cell from its nearest place on the circle.
    """

    found: DecodeResult
    markers: tuple[int, ...]
    marker_error_mm: float
    phase_error_rad: float


def paint(pdf: Path, raster: str, dpi: int) -> Raster | None:
    """Page 1 as one of `RASTERS` paints it; None where that one is not installed."""
    out = pdf.with_suffix(".painted")
    if raster == "ghostscript":
        program, file = shutil.which("gs"), out
        options = ["-q", "-dNOPAUSE", "-dBATCH", "-dLastPage=1", "-sDEVICE=pbmraw", f"-r{dpi}", f"-sOutputFile={out}"]
        command = [*options, str(pdf)]
    else:
        program, (kind, ending) = (
            shutil.which("pdftoppm"),
            ("-mono", "pbm") if raster == "poppler" else ("-gray", "pgm"),
        )
        file = Path(f"{out}.{ending}")
        command = [kind, "-r", str(dpi), "-f", "1", "-singlefile", str(pdf), str(out)]
    if program is None:
        return None
    done = subprocess.run([program, *command], capture_output=True, text=True)
    if done.returncode:
        raise FabricationError(f"{raster} cannot paint {pdf.name} at {dpi} dpi: {done.stderr.strip()[:200]}")
    picture = _netpbm(file, dpi)
    file.unlink()
    return picture


def _netpbm(file: Path, dpi: int) -> Raster:
    """A binary netpbm file of one bit (P4) or one byte (P5) a dot.

    Read here because Pillow would unpack a page to a byte a dot, 2.2 GB at 4800 dpi.
    """
    content = file.read_bytes()
    words: list[bytes] = []
    place = 0
    while len(words) < (3 if content.startswith(b"P4") else 4):
        end = content.index(b"\n", place)
        words += content[place:end].split(b"#")[0].split()
        place = end + 1
    width, height = int(words[1]), int(words[2])
    dots = np.frombuffer(content, np.uint8, offset=place)
    if words[0] == b"P5":
        return Raster(np.packbits(dots.reshape(height, width) < 128, axis=1), width, dpi)
    return Raster(dots.reshape(height, -1), width, dpi)


def without_lines(badge: Badge) -> Badge:
    """What a verifier may know before it reads: the layout, but no lines, name or id of a person."""

    def blank(grating: Grating) -> Grating:
        pitch = badge.lens.pitch_mm
        cells = tuple(replace(cell, pitch_mm=pitch, edge_mm=0.0) for cell in grating.cells)
        return replace(grating, pitch_mm=pitch, cells=cells)

    return replace(badge, id=None, name="unknown", gratings=tuple(blank(grating) for grating in badge.gratings))


def read_page(page: Raster, known: Badge) -> PageReading | None:
    """Find the markers and decode the identity; None where fewer than three markers are found.

    Parameters: known: whose layout is used, see `without_lines`; its lines are never looked at.
    Convention: as `idcodes.spacing`: a cell's fringe is ahead where its lines are shifted back.
    Source: centres of dark lines, a straight line through those of each uniform row; no pitch is assumed.
    """
    placed = place_page(page, known)
    if placed is None:
        return None
    to_dots, ids, marker_error_mm = placed
    readings, worst = [], 0.0
    for grating in known.gratings:
        assert grating.code is not None
        k = 0 if grating.axis == "x" else 1
        middle = line_centres(page, grating, grating.cells[grating.code.reference_cell], to_dots)
        pitch, first = np.polyfit(np.arange(len(middle)), middle, 1)
        row = []
        for role, cell in zip(grating.code.roles, grating.cells, strict=True):
            centres = line_centres(page, grating, cell, to_dots)
            if len(centres) < 2:
                row.append(CellReading(math.nan, math.inf, math.nan, math.inf))
            elif role == "phase":
                turn = np.exp(2j * math.pi * (centres - first) / pitch).mean()
                # A line's centre is uniform over half a dot either way at most.
                sd = 2 * math.pi / pitch / math.sqrt(12 * len(centres))
                phase = -float(np.angle(turn))
                row.append(CellReading(math.nan, math.inf, phase, sd))
                worst = max(worst, abs(math.remainder(phase, 2 * math.pi / (grating.code.phase_levels or 4))))
            else:
                own = np.polyfit(np.arange(len(centres)), centres, 1)[0] / to_dots[k][0]
                sd = 1e-5  # a millicycle over 100 mm, as `verifier.identity` has it
                row.append(CellReading(1 / own - 1 / known.lens.pitch_mm, sd, math.nan, math.inf))
        readings.append(row)
    found = family_named(known.gratings[0].family).read(readings, known.gratings)
    return PageReading(found, ids, marker_error_mm, worst)


def line_centres(page: Raster, grating: Grating, cell: Cell, to_dots: Array) -> Array:
    """Centres of the whole dark lines on a cell's middle, in dots; to_dots as `place_page` has it."""
    begins, ends, _ = line_edges(page, grating, cell, to_dots)
    ends = ends[ends > begins[0]] if len(begins) else ends
    count = min(len(begins), len(ends))
    return np.asarray((begins[:count] + ends[:count]) / 2)


def line_edges(page: Raster, grating: Grating, cell: Cell, to_dots: Array) -> tuple[Array, Array, float]:
    """Borders between dots at which dark lines begin, and at which they end, on a cell's middle, clear of its ends and
    of what its neighbours bend; and where across that is, mm.
    """
    k = 0 if grating.axis == "x" else 1
    across = (cell.rect_mm[1 - k] + cell.rect_mm[3 - k]) / 2
    rim = rims_mm(grating)[grating.cells.index(cell)][0] if is_smooth(grating) else 0.0
    margin = max(MARGIN_MM, rim)
    number = int(to_dots[1 - k] @ (across, 1.0))
    dots = page.line(str(grating.axis), number)
    low, high = (float(to_dots[k] @ (v, 1.0)) for v in (cell.rect_mm[k] + margin, cell.rect_mm[k + 2] - margin))
    steps = np.diff(dots.astype(np.int8))
    begins, ends = ((np.flatnonzero(steps == sign) + 1).astype(float) for sign in (1, -1))
    across = float((number + 0.5 - to_dots[1 - k][1]) / to_dots[1 - k][0])
    return begins[(begins > low) & (begins < high)], ends[(ends > low) & (ends < high)], across


def place_page(page: Raster, known: Badge) -> tuple[Array, tuple[int, ...], float] | None:
    """Where page millimetres lie on a raster, by the markers that OpenCV finds on it.

    Returns: rows (scale, offset) for x and y that turn mm into dots, the ids found, and the worst corner's distance
        from its place, mm; None where fewer than three markers are found.
    """
    import cv2

    times = max(1, round(page.dpi / MARKER_DPI))
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    # Small boards have markers below OpenCV's default share of the picture's width.
    settings.minMarkerPerimeterRate = 0.01
    finder = cv2.aruco.ArucoDetector(
        cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, known.squares.dictionary)), settings
    )
    quads, ids, _ = finder.detectMarkers(page.shrunk(times))
    centres = dict(zip(known.squares.ids, known.squares.centers_mm, strict=True))
    half = known.squares.size_mm / 2
    seen, true, names = [], [], []
    for quad, number in zip(quads, [] if ids is None else np.ravel(ids), strict=True):
        if int(number) in centres:
            x, y = centres[int(number)]
            # OpenCV counts from the middle of the first pixel.
            seen.append((quad.reshape(4, 2) + 0.5) * times)
            true.append([(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)])
            names.append(int(number))
    if len(set(names)) < 3:
        return None
    dots, mm = np.concatenate(seen).astype(float), np.array(true).reshape(-1, 2)
    fits = np.array([np.polyfit(mm[:, k], dots[:, k], 1) for k in (0, 1)])
    off = (dots - (mm * fits[:, 0] + fits[:, 1])) / fits[:, 0]
    return fits, tuple(sorted(names)), float(np.hypot(*off.T).max())
