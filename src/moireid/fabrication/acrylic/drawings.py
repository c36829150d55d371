"""The laser's drawing as two files, read back and checked: acrylic.dxf for CAM, acrylic.svg for drawing programs.

It holds what is cut, with kerf compensated, and a scale to measure it by.  Plates and film are side by side.  Each has
its own cutting layer, because each may be cut from another plate.  Most laser shops use these colours: red cuts, blue
engraves, and grey notes are only for people.

Convention: mm, y up.  The DXF file is AutoCAD R2010, in millimetres.  In the SVG file a user unit is one millimetre,
and y runs down, so an arc that turns left in the drawing has sweep flag 0.  `kerf_mm` is the whole burnt width; the
lines drawn are the laser's path, half the kerf outside each outline and inside each opening.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from moireid.errors import FabricationError
from moireid.fabrication.acrylic.contours import Contour
from moireid.fabrication.acrylic.plates import AcrylicPlan
from moireid.fabrication.dxf_file import sound_dxf, written_dxf
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
        what = f"{plate.thickness_mm:g} mm" + (" polyester film" if plate.name == "lips" else "")
        notes.append((x, floor - 2 * TEXT_MM, f"{plate.name.upper()}: {what}"))
        x, height = x + x1 - x0 + GAP_MM, y1 - y0
    rule = f"kerf {kerf_mm:g} mm: paths lie {kerf_mm / 2:g} mm outside outlines and inside openings"
    notes.append((GAP_MM + SCALE_MM + 5, GAP_MM, f"{SCALE_MM:g} mm; {rule}; red cuts, blue engraves"))
    strokes = [(GAP_MM, GAP_MM, GAP_MM + SCALE_MM, GAP_MM)]
    strokes += [(GAP_MM + k, GAP_MM, GAP_MM + k, GAP_MM + (4 if k % 50 == 0 else 2)) for k in range(0, 101, 10)]
    width = max(x, GAP_MM + SCALE_MM + 10 + 0.62 * TEXT_MM * len(notes[-1][2]))
    drawing = CuttingDrawing(cuts, tuple(strokes), tuple(notes), (width, floor + height + GAP_MM))
    check_cuts(cuts, kerf_mm)
    return drawing


def check_cuts(cuts: dict[str, tuple[Contour, ...]], kerf_mm: float) -> None:
    """Check that some plate is left between any two burnt lines, and that only the first path has others inside.

    Raises: FabricationError where they do.
    """
    manifold3d = cad_package("manifold3d")
    for layer, paths in cuts.items():
        areas = [manifold3d.CrossSection([path.flat()]) for path in paths]
        # Half of what must lie between two paths, less a hundredth for the arcs' flat pieces.
        apart = (kerf_mm + LEAST_LAND_MM) / 2 - 0.01
        fat = [area.offset(apart, manifold3d.JoinType.Round) for area in areas[1:]]
        room = areas[0].offset(-apart, manifold3d.JoinType.Round)
        crossing = [k for k, area in enumerate(fat) if (area - room).area() > 1e-6]
        crossing += [k for k, area in enumerate(fat) for other in fat[:k] if (area ^ other).area() > 1e-6]
        if crossing:
            raise refused_drawing(
                "drawing",
                f"has paths on {layer} that overlap or nearly meet",
                f"{LEAST_LAND_MM:g} mm of plate between them",
            )


def check_found(what: str, found: dict[str, list[list[Vertex]]], drawing: CuttingDrawing) -> None:
    """Check that a file read back has each cutting path of the drawing once.  Raises: FabricationError."""
    if set(found) != set(drawing.cuts):
        raise refused_drawing(what, f"has the cutting layers {sorted(found)}", f"{sorted(drawing.cuts)}")
    for layer, paths in drawing.cuts.items():
        if len(found[layer]) != len(paths):
            raise refused_drawing(what, f"has {len(found[layer])} paths on {layer}", f"{len(paths)}")
        for got, path in zip(found[layer], paths, strict=True):
            wanted = path.vertices()
            pairs = zip(got, wanted, strict=False)
            if len(got) != len(wanted) or max(math.dist(a, b) for a, b in pairs) > ROUNDING_MM:
                raise refused_drawing(
                    what, f"has another path on {layer} than drawn", f"less than {ROUNDING_MM:g} mm off"
                )


def refused_drawing(what: str, got: str, allowed: str) -> FabricationError:
    """The error of a drawing that failed its check."""
    return FabricationError(
        f"the acrylic parts' {what} {got}, allowed is {allowed}; nothing was kept: choose other process figures, and "
        "report this if the defaults fail"
    )


HAIRLINE_MM = 0.1


def write_dxf(drawing: CuttingDrawing, path: Path) -> None:
    """Write a DXF R2010 file, mm.  Raises: MissingExtraError without ezdxf."""
    with written_dxf(path) as document:
        space = document.modelspace()
        for layer, paths in drawing.cuts.items():
            document.layers.add(layer, color=CUT[0])
            for contour in paths:
                space.add_lwpolyline(contour.vertices(), format="xyb", close=True, dxfattribs={"layer": layer})
        document.layers.add("ENGRAVE-SCALE", color=ENGRAVE[0])
        document.layers.add("NOTE", color=NOTE[0])
        for x0, y0, x1, y1 in drawing.strokes:
            space.add_line((x0, y0), (x1, y1), dxfattribs={"layer": "ENGRAVE-SCALE"})
        for x, y, words in drawing.notes:
            space.add_text(words, height=TEXT_MM, dxfattribs={"layer": "NOTE"}).set_placement((x, y))


def check_dxf(path: Path, drawing: CuttingDrawing) -> None:
    """Read a DXF file back: no faults in the audit, millimetres, closed paths where they were drawn, none over another.

    Raises: FabricationError with what was found and what is allowed.
    """
    document = sound_dxf(path, partial(refused_drawing, "DXF"))
    found: dict[str, list[list[Vertex]]] = {}
    for entity in document.modelspace():
        layer = entity.dxf.layer
        if not layer.startswith("CUT-"):
            continue
        if entity.dxftype() != "LWPOLYLINE" or not entity.closed:
            raise refused_drawing("DXF", f"has an open path on {layer}", "closed polylines alone")
        if document.layers.get(layer).color != CUT[0]:
            raise refused_drawing(
                "DXF", f"shows {layer} in colour {document.layers.get(layer).color}", f"{CUT[0]}, red"
            )
        found.setdefault(layer, []).append([tuple(vertex) for vertex in entity.get_points("xyb")])
    check_found("DXF", found, drawing)


def write_svg(drawing: CuttingDrawing, path: Path) -> None:
    """Write an SVG file whose size is given in millimetres."""
    width, height = drawing.size_mm
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3f}mm" height="{height:.3f}mm" '
        f'viewBox="0 0 {width:.3f} {height:.3f}">',
    ]
    for layer, paths in drawing.cuts.items():
        data = " ".join(_svg_path(contour.vertices(), height) for contour in paths)
        lines.append(_svg_group(layer, CUT[1], f'<path d="{data}"/>'))
    strokes = " ".join(
        f"M {x0:.5f} {height - y0:.5f} L {x1:.5f} {height - y1:.5f}" for x0, y0, x1, y1 in drawing.strokes
    )
    lines.append(_svg_group("ENGRAVE-SCALE", ENGRAVE[1], f'<path d="{strokes}"/>'))
    words = "".join(f'<text x="{x:.3f}" y="{height - y:.3f}">{escape(note)}</text>' for x, y, note in drawing.notes)
    lines.append(f'<g id="NOTE" fill="{NOTE[1]}" font-family="sans-serif" font-size="{TEXT_MM:g}">{words}</g>')
    path.write_text("\n".join([*lines, "</svg>", ""]), encoding="utf-8")


def check_svg(path: Path, drawing: CuttingDrawing) -> None:
    """Read an SVG file back: its size in mm, and the same closed red paths as were drawn.

    Raises: FabricationError with what was found and what is allowed.
    """
    svgelements = cad_package("svgelements")
    try:
        document = svgelements.SVG.parse(path, on_error="raise")
    except (ElementTree.ParseError, ValueError) as error:
        raise refused_drawing("SVG", "cannot be read back", "a readable file") from error
    # The reader gives pixels, with a millimetre rounded to six digits.
    px_per_mm = svgelements.Length("1mm").value(ppi=svgelements.DEFAULT_PPI)
    width, height, box = document.width / px_per_mm, document.height / px_per_mm, document.viewbox
    if max(abs(width - box.width), abs(height - box.height), abs(width - drawing.size_mm[0])) > 0.01:
        view = f"{box.width:g} x {box.height:g}"
        raise refused_drawing("SVG", f"is {width:g} x {height:g} mm for a view of {view}", "one unit a mm")
    found: dict[str, list[list[Vertex]]] = {}
    for group in document:
        for drawn in group:
            if str(group.id).startswith("CUT-") and drawn.stroke == CUT[1]:
                runs = (list(run) for run in drawn.as_subpaths())
                closed = [run[1:-1] for run in runs if isinstance(run[-1], svgelements.Close)]
                found.setdefault(group.id, []).extend(_vertices(steps, px_per_mm, height) for steps in closed)
    check_found("SVG", found, drawing)


def _svg_group(name: str, colour: str, content: str) -> str:
    return f'<g id={quoteattr(name)} fill="none" stroke="{colour}" stroke-width="{HAIRLINE_MM:g}">{content}</g>'


def _svg_path(vertices: list[Vertex], height: float) -> str:
    """One closed path; a bulge becomes an arc, which turns the other way as y is turned."""
    words = [f"M {vertices[0][0]:.5f} {height - vertices[0][1]:.5f}"]
    for k, (x, y, bulge) in enumerate(vertices):
        end_x, end_y, _ = vertices[(k + 1) % len(vertices)]
        end = f"{end_x:.5f} {height - end_y:.5f}"
        if bulge == 0:
            words.append(f"L {end}")
            continue
        radius = math.dist((x, y), (end_x, end_y)) * (1 + bulge * bulge) / (4 * abs(bulge))
        words.append(f"A {radius:.5f} {radius:.5f} 0 {int(abs(bulge) > 1)} {int(bulge < 0)} {end}")
    return " ".join([*words, "Z"])


def _vertices(steps: list[Any], px_per_mm: float, height: float) -> list[Vertex]:
    """Vertices with bulges, y up, of the lines and arcs of one subpath, as svgelements reads them."""
    return [
        (step.start.x / px_per_mm, height - step.start.y / px_per_mm, -math.tan(getattr(step, "sweep", 0.0) / 4))
        for step in steps
    ]
