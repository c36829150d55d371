"""What a PDF page holds, as geometry: for the tests of pages and of sheets."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path

import pypdfium2 as pdfium
import pypdfium2.raw as raw

from moireid.badge import Rect

PT_PER_MM = 72 / 25.4


@dataclass(frozen=True)
class Drawn:
    """What a page holds, mm from its top left: filled rectangles with their grey (0 to 255), and straight strokes."""

    fills: list[tuple[Rect, int]]
    strokes: list[tuple[float, float, float, float]]


def geometry(path: Path, number: int = 0) -> Drawn:
    """Every path of a page, the first unless another is asked for, read by PDFium without drawing it."""
    document = pdfium.PdfDocument(path)
    sheet = document[number]
    height = sheet.get_height()
    fills, strokes = [], []
    x, y = ctypes.c_float(), ctypes.c_float()
    for thing in sheet.get_objects(filter=[raw.FPDF_PAGEOBJ_PATH]):
        points = []
        for k in range(raw.FPDFPath_CountSegments(thing.raw)):
            raw.FPDFPathSegment_GetPoint(raw.FPDFPath_GetPathSegment(thing.raw, k), x, y)
            points.append((x.value / PT_PER_MM, (height - y.value) / PT_PER_MM))
        if len(points) == 2:
            strokes.append((*points[0], *points[1]))
            continue
        red, other = ctypes.c_uint(), ctypes.c_uint()
        raw.FPDFPageObj_GetFillColor(thing.raw, red, other, other, other)
        for k in range(0, len(points), 5):
            xs, ys = zip(*points[k : k + 5], strict=True)
            fills.append(((min(xs), min(ys), max(xs), max(ys)), red.value))
    document.close()
    return Drawn(fills, strokes)
