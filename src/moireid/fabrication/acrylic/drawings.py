"""The laser's drawing as two files, read back and checked: acrylic.dxf for CAM, acrylic.svg for drawing programs.

Convention: the DXF file is AutoCAD R2010, in millimetres, y up.  In the SVG file a user unit is one millimetre, and y
runs down, so an arc that turns left in the drawing has sweep flag 0.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from moireid.fabrication.acrylic.cutting import (
    CUT,
    ENGRAVE,
    NOTE,
    TEXT_MM,
    CuttingDrawing,
    Vertex,
    check_found,
    refused,
)
from moireid.fabrication.solids import cad_package

HAIRLINE_MM = 0.1


def write_dxf(drawing: CuttingDrawing, path: Path) -> None:
    """Write a DXF R2010 file, mm.  Raises: MissingExtraError without ezdxf."""
    ezdxf = cad_package("ezdxf")
    before = ezdxf.options.write_fixed_meta_data_for_testing
    # Without this the file would hold the time of writing, and the same badge would never give the same bytes.
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        document = ezdxf.new("R2010", units=ezdxf.units.MM)
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
        # ezdxf adds these in the order of a set, which changes from run to run.
        document.classes.add_required_classes(document.dxfversion)
        document.classes.classes = dict(sorted(document.classes.classes.items()))
        document.saveas(path)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def check_dxf(path: Path, drawing: CuttingDrawing, kerf_mm: float) -> None:
    """Read a DXF file back: no faults in the audit, millimetres, closed paths where they were drawn, none over another.

    Raises: FabricationError with what was found and what is allowed.
    """
    ezdxf = cad_package("ezdxf")
    try:
        document = ezdxf.readfile(path)
    except (OSError, ValueError, StopIteration, ezdxf.DXFError) as error:
        raise refused("DXF", "cannot be read back", "a readable file") from error
    audit = document.audit()
    # A fault that ezdxf repairs on reading counts too, because another program may not repair it.
    if faults := [*audit.errors, *audit.fixes]:
        raise refused("DXF", f"has {len(faults)} faults in its audit ({faults[0].message})", "none")
    if document.units != ezdxf.units.MM:
        raise refused("DXF", f"counts in unit {document.units}", "millimetres (4)")
    found: dict[str, list[list[Vertex]]] = {}
    for entity in document.modelspace():
        layer = entity.dxf.layer
        if not layer.startswith("CUT-"):
            continue
        if entity.dxftype() != "LWPOLYLINE" or not entity.closed:
            raise refused("DXF", f"has an open path on {layer}", "closed polylines alone")
        if document.layers.get(layer).color != CUT[0]:
            raise refused("DXF", f"shows {layer} in colour {document.layers.get(layer).color}", f"{CUT[0]}, red")
        found.setdefault(layer, []).append([tuple(vertex) for vertex in entity.get_points("xyb")])
    check_found("DXF", found, drawing, kerf_mm)


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


def check_svg(path: Path, drawing: CuttingDrawing, kerf_mm: float) -> None:
    """Read an SVG file back: its size in mm, and the same closed red paths as were drawn.

    Raises: FabricationError with what was found and what is allowed.
    """
    svgelements = cad_package("svgelements")
    try:
        document = svgelements.SVG.parse(path, on_error="raise")
    except (ElementTree.ParseError, ValueError) as error:
        raise refused("SVG", "cannot be read back", "a readable file") from error
    # The reader gives pixels, with a millimetre rounded to six digits.
    px_per_mm = svgelements.Length("1mm").value(ppi=svgelements.DEFAULT_PPI)
    width, height, box = document.width / px_per_mm, document.height / px_per_mm, document.viewbox
    if max(abs(width - box.width), abs(height - box.height), abs(width - drawing.size_mm[0])) > 0.01:
        view = f"{box.width:g} x {box.height:g}"
        raise refused("SVG", f"is {width:g} x {height:g} mm for a view of {view}", "one unit a mm")
    found: dict[str, list[list[Vertex]]] = {}
    for group in document:
        for drawn in group:
            if str(group.id).startswith("CUT-") and drawn.stroke == CUT[1]:
                runs = (list(run) for run in drawn.as_subpaths())
                closed = [run[1:-1] for run in runs if isinstance(run[-1], svgelements.Close)]
                found.setdefault(group.id, []).extend(_vertices(steps, px_per_mm, height) for steps in closed)
    check_found("SVG", found, drawing, kerf_mm)


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
