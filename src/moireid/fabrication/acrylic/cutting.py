"""The laser's drawing: what is cut, with kerf compensated, and a scale to measure it by.

Base, frame and cover lie side by side.  Each has its own cutting layer, because each is cut from another plate.
Most laser shops use these colours: red cuts, blue engraves, and grey notes are only for people.

Convention: mm, y up.  `kerf_mm` is the whole burnt width; the lines drawn are the laser's path, half the kerf outside
each outline and inside each opening.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from moireid.errors import FabricationError
from moireid.fabrication.acrylic.contour import Contour
from moireid.fabrication.acrylic.plates import AcrylicPlan
from moireid.fabrication.process_figures import LEAST_LAND_MM
from moireid.fabrication.solids import cad_package

#: Layer colours: AutoCAD colour index, and the same as SVG.
CUT, ENGRAVE, NOTE = (1, "#ff0000"), (5, "#0000ff"), (8, "#808080")
GAP_MM, TEXT_MM = 15.0, 4.0
#: The scale bar is engraved, so that a ruler on the finished plate shows whether a program changed the drawing's size.
SCALE_MM = 100.0
#: Rounding error of a coordinate that is written in decimals, mm.
ROUNDING_MM = 1e-4
#: A corner as (x, y, bulge), as `Contour.vertices` gives it.
Vertex = tuple[float, float, float]


@dataclass(frozen=True)
class CuttingDrawing:
    """All that both files hold: cutting paths by layer, the scale's strokes, and notes at their places."""

    cuts: dict[str, tuple[Contour, ...]]
    strokes: tuple[tuple[float, float, float, float], ...]
    notes: tuple[tuple[float, float, str], ...]
    size_mm: tuple[float, float]


def draw(plan: AcrylicPlan, kerf_mm: float) -> CuttingDrawing:
    """Lay the plates out side by side above a scale bar.

    Raises: FabricationError where too little is left between two paths, or a corner has no room for the kerf.
    """
    cuts: dict[str, tuple[Contour, ...]] = {}
    notes: list[tuple[float, float, str]] = []
    x, floor = GAP_MM, GAP_MM + 5 * TEXT_MM
    for plate in plan.plates:
        paths = plate.cuts(kerf_mm)
        x0, y0, x1, y1 = paths[0].bounds
        cuts[f"CUT-{plate.name.upper()}-{plate.thickness_mm:g}MM"] = tuple(p.moved(x - x0, floor - y0) for p in paths)
        notes.append((x, floor - 2 * TEXT_MM, f"{plate.name.upper()}: {plate.thickness_mm:g} mm"))
        x, height = x + x1 - x0 + GAP_MM, y1 - y0
    rule = f"kerf {kerf_mm:g} mm: paths lie {kerf_mm / 2:g} mm outside outlines and inside openings"
    notes.append((GAP_MM + SCALE_MM + 5, GAP_MM, f"{SCALE_MM:g} mm; {rule}; red cuts, blue engraves"))
    strokes = [(GAP_MM, GAP_MM, GAP_MM + SCALE_MM, GAP_MM)]
    strokes += [(GAP_MM + k, GAP_MM, GAP_MM + k, GAP_MM + (4 if k % 50 == 0 else 2)) for k in range(0, 101, 10)]
    width = max(x, GAP_MM + SCALE_MM + 10 + 0.62 * TEXT_MM * len(notes[-1][2]))
    drawing = CuttingDrawing(cuts, tuple(strokes), tuple(notes), (width, floor + height + GAP_MM))
    check_cuts(((layer, [path.vertices() for path in paths]) for layer, paths in cuts.items()), kerf_mm, "drawing")
    return drawing


def check_cuts(layers: Iterable[tuple[str, list[list[Vertex]]]], kerf_mm: float, what: str) -> None:
    """Check that some plate is left between any two burnt lines, and that only the first path has others inside.

    Raises: FabricationError where they do.
    """
    manifold3d = cad_package("manifold3d")
    for layer, paths in layers:
        areas = [manifold3d.CrossSection([flat(path)]) for path in paths]
        # Half of what must lie between two paths, less a hundredth for the arcs' flat pieces.
        apart = (kerf_mm + LEAST_LAND_MM) / 2 - 0.01
        fat = [area.offset(apart, manifold3d.JoinType.Round) for area in areas[1:]]
        room = areas[0].offset(-apart, manifold3d.JoinType.Round)
        crossing = [k for k, area in enumerate(fat) if (area - room).area() > 1e-6]
        crossing += [k for k, area in enumerate(fat) for other in fat[:k] if (area ^ other).area() > 1e-6]
        if crossing:
            raise refused(
                what, f"has paths on {layer} that overlap or nearly meet", f"{LEAST_LAND_MM:g} mm of plate between them"
            )


def check_found(what: str, found: dict[str, list[list[Vertex]]], drawing: CuttingDrawing, kerf_mm: float) -> None:
    """Check that a file read back has each cutting path of the drawing once.  Raises: FabricationError."""
    if set(found) != set(drawing.cuts):
        raise refused(what, f"has the cutting layers {sorted(found)}", f"{sorted(drawing.cuts)}")
    for layer, paths in drawing.cuts.items():
        if len(found[layer]) != len(paths):
            raise refused(what, f"has {len(found[layer])} paths on {layer}", f"{len(paths)}")
        for got, path in zip(found[layer], paths, strict=True):
            wanted = path.vertices()
            pairs = zip(got, wanted, strict=False)
            if len(got) != len(wanted) or max(math.dist(a, b) for a, b in pairs) > ROUNDING_MM:
                raise refused(what, f"has another path on {layer} than was drawn", f"less than {ROUNDING_MM:g} mm off")
    check_cuts(found.items(), kerf_mm, what)


def flat(vertices: list[Vertex], steps: int = 16) -> list[tuple[float, float]]:
    """A path as a polygon, each arc in `steps` pieces."""
    points: list[tuple[float, float]] = []
    for k, (x, y, bulge) in enumerate(vertices):
        points.append((x, y))
        if bulge == 0:
            continue
        end_x, end_y, _ = vertices[(k + 1) % len(vertices)]
        # The centre lies on the chord's bisector, to its left for an arc that turns left by less than a half turn.
        offset = (1 - bulge * bulge) / (4 * bulge)
        cx, cy = (x + end_x) / 2 - (end_y - y) * offset, (y + end_y) / 2 + (end_x - x) * offset
        angle = 4 * math.atan(bulge)
        for step in range(1, steps):
            cos, sin = math.cos(angle * step / steps), math.sin(angle * step / steps)
            points.append((cx + (x - cx) * cos - (y - cy) * sin, cy + (x - cx) * sin + (y - cy) * cos))
    return points


def refused(what: str, got: str, allowed: str) -> FabricationError:
    """The error of a drawing that failed its check."""
    return FabricationError(
        f"the acrylic parts' {what} {got}, allowed is {allowed}; nothing was kept: choose other process figures, and "
        "report this if the defaults fail"
    )
