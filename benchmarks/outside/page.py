"""The page as a raster, and the sheets placed on it.

Of `badge.json` only what a builder knows is read: outline, lens sheet, and rectangles and axes of the fields.
Source: `docs/how-to/wear.md` and the assembly sheet for what is placed where; pdfium for the raster.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from outside.bend import Bend

DPI, POINTS_PER_INCH, MM_PER_INCH = 1200, 72.0, 25.4
#: Reflectance of toner and of card.
INK, PAPER = 0.05, 0.85
#: Toner spreads by about this much at an edge, mm (standard deviation).
PRINTER_BLUR_MM = 0.012
#: Text and markers are looked up in a raster reduced by this.
COARSE = 3
#: A piece of lens sheet is cut a little wider than the field, across its lenses, mm.
OVERHANG_MM = 1.0
UNBENT = Bend()


@dataclass(frozen=True)
class Lens:
    """What is known of a sheet: sizes in mm; air_mm between its back and the print; conic: constant of the profile, 0
    for a circle, -1 / index^2 for the ellipse that focuses."""

    pitch_mm: float
    thickness_mm: float
    index: float
    radius_mm: float
    air_mm: float = 0.0
    conic: float = 0.0

    @property
    def figures(self) -> NDArray[np.float64]:
        """As `trace.trace` reads."""
        return np.array([self.thickness_mm, self.index, self.radius_mm, self.air_mm, self.conic])


@dataclass(frozen=True)
class Sheet:
    """Where a sheet is to lie: its centre in the badge frame, half sizes across and along its lenses, axis as angle."""

    center_mm: tuple[float, float]
    half_mm: tuple[float, float]
    angle_rad: float


@dataclass(frozen=True)
class Page:
    """The board as printed.

    fine, coarse: reflectance, 0 to 1 as bytes 0 to 255; px_per_mm: of the fine one, along x and y; size_mm: the board;
    air_mm: a map over the board of the air under its sheets, in place of the lens's one figure; bend: its shape.
    """

    fine: NDArray[np.uint8]
    coarse: NDArray[np.uint8]
    px_per_mm: tuple[float, float]
    size_mm: tuple[float, float]
    lens: Lens
    sheets: tuple[Sheet, ...]
    air_mm: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), np.float32))
    bend: Bend = UNBENT


def load_page(folder: Path, *, edge_to_edge: bool = False) -> Page:
    """Rasterise `badge.pdf` of the folder, and read what a builder knows.

    edge_to_edge: a sheet over one field reaches from the board's left edge to its right one, where mounts hold it.
    """
    document = json.loads((folder / "badge.json").read_text(encoding="utf-8"))
    page = document["page"]["width_mm"], document["page"]["height_mm"]
    rect = document.get("board", {}).get("rect_mm", [0.0, 0.0, *page])
    fine, px_per_mm = rasterise(folder / "badge.pdf", rect)
    size = rect[2] - rect[0], rect[3] - rect[1]
    sheets = _sheets(document, rect, page)
    if edge_to_edge:
        sheets = tuple(
            replace(one, center_mm=(0.0, one.center_mm[1]), half_mm=(size[0] / 2, one.half_mm[1])) for one in sheets
        )
    return from_raster(fine, px_per_mm, size, _lens(document["lens"]), sheets)


def from_raster(
    grey: NDArray[np.uint8],
    px_per_mm: tuple[float, float],
    size_mm: tuple[float, float],
    lens: Lens,
    sheets: tuple[Sheet, ...],
) -> Page:
    """A page from a grey picture of it, 0 black to 255 white: blurred as a printer does, in reflectance."""
    sigma = PRINTER_BLUR_MM * px_per_mm[0]
    fine = cv2.GaussianBlur(grey, (0, 0), sigma) if sigma > 0.3 else grey
    table = np.rint(255 * (INK + (PAPER - INK) * np.arange(256) / 255)).astype(np.uint8)
    fine = table[fine]
    coarse = cv2.resize(fine, (fine.shape[1] // COARSE, fine.shape[0] // COARSE), interpolation=cv2.INTER_AREA)
    return Page(fine, coarse, px_per_mm, size_mm, lens, sheets)


def rasterise(pdf: Path, rect_mm: list[float]) -> tuple[NDArray[np.uint8], tuple[float, float]]:
    """Page 1 within the rectangle, grey, at `DPI`, and the pixels in a mm along x and y.

    pdfium draws a page to a whole number of pixels, which stretches it by less than one: hence two scales.
    """
    import pypdfium2

    document = pypdfium2.PdfDocument(pdf)
    page = document[0]
    width, height = page.get_size()
    scale = DPI / POINTS_PER_INCH
    picture = page.render(scale=scale, grayscale=True).to_numpy().squeeze()
    across = picture.shape[1] / (width * MM_PER_INCH / POINTS_PER_INCH)
    down = picture.shape[0] / (height * MM_PER_INCH / POINTS_PER_INCH)
    # Whole pixels are cut and the rest of a pixel is shifted, so that the board's corner is pixel corner (0, 0).
    x0, y0, x1, y1 = rect_mm[0] * across, rect_mm[1] * down, rect_mm[2] * across, rect_mm[3] * down
    left, top = math.floor(x0), math.floor(y0)
    cut = picture[top : math.ceil(y1) + 1, left : math.ceil(x1) + 1]
    shift = np.array([[1.0, 0.0, left - x0], [0.0, 1.0, top - y0]])
    size = math.ceil(x1 - x0), math.ceil(y1 - y0)
    moved = cv2.warpAffine(cut, shift, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    document.close()
    return moved, (across, down)


def _lens(entry: dict[str, object]) -> Lens:
    """The sheet as bought; its lenses focus on the flat back where nothing else is said."""
    pitch, thickness, index = (float(entry[k]) for k in ("pitch_mm", "thickness_mm", "refractive_index"))  # type: ignore[arg-type]
    radius = float(entry.get("radius_mm") or thickness * (index - 1.0) / index)  # type: ignore[arg-type]
    if entry["kind"] != "lenticular":
        raise ValueError(f"a front of kind {entry['kind']} is not traced here; give lenses")
    return Lens(pitch, thickness, index, radius)


def _sheets(document: dict[str, object], rect: list[float], page: tuple[float, float]) -> tuple[Sheet, ...]:
    """One sheet a field."""
    center = (rect[0] + rect[2]) / 2, (rect[1] + rect[3]) / 2
    found: list[Sheet] = []
    for grating in document["gratings"]:  # type: ignore[attr-defined]
        x0, y0, x1, y1 = grating["rect_mm"]
        half, middle, angle = ((x1 - x0) / 2, (y1 - y0) / 2), ((x0 + x1) / 2, (y0 + y1) / 2), 0.0
        if grating["axis"] == "y":
            half, angle = half[::-1], math.pi / 2
        elif grating["axis"] != "x":
            # The rectangle of a turned field lies in a frame turned about the page's centre.
            angle = math.radians(grating["axis"])
            dx, dy = middle[0] - page[0] / 2, middle[1] - page[1] / 2
            cosine, sine = math.cos(angle), math.sin(angle)
            middle = page[0] / 2 + dx * cosine - dy * sine, page[1] / 2 + dx * sine + dy * cosine
        found.append(Sheet((middle[0] - center[0], middle[1] - center[1]), (half[0] + OVERHANG_MM, half[1]), angle))
    return tuple(found)
