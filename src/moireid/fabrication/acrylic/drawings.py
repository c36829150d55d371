"""The laser's drawings as DXF for CAM and SVG for drawing programs, read back and checked: all plates, and each stock.

A drawing holds what is cut, with kerf compensated, and a scale to measure it by.  A stock, such as acrylic of 3 mm, has
one layer and one colour, because programs such as LightBurn make a layer of each colour; these also leave out text, so
words are drawn as strokes.  Scale and words are engraved, in blue, next to the plates.

Convention: mm, y up.  The DXF file is AutoCAD R2010, in millimetres.  In the SVG file a user unit is one millimetre,
and y runs down, so an arc that turns left in the drawing has sweep flag 0.  `kerf_mm` is the whole burnt width; the
lines drawn are the laser's path, half the kerf outside each outline and inside each opening.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from moireid.badge import Point
from moireid.fabrication.acrylic.contours import Contour
from moireid.fabrication.acrylic.plates import AcrylicPlan, Plate
from moireid.fabrication.process_figures import LEAST_LAND_MM
from moireid.fabrication.solids import cad_package, refused
from moireid.fabrication.text.outlines import line_strokes
from moireid.fabrication.text.shaping import shape_line

#: Colours of what is engraved, and of the stocks in the stack's order: AutoCAD colour index, and the same as SVG.
#: Each is nearest to another of LightBurn's layers (its documentation, colour palette).
ENGRAVE = (5, "#0000ff")
CUTS = ((1, "#ff0000"), (3, "#00ff00"), (6, "#ff00ff"), (4, "#00ffff"))
ENGRAVED = "ENGRAVE"
GAP_MM, LETTERS_MM = 15.0, 4.2
#: The scale bar is engraved, so that a ruler on the finished plate shows whether a program changed the drawing's size.
SCALE_MM = 100.0
#: Rounding error of a coordinate that is written in decimals, mm.
ROUNDING_MM = 1e-4
#: A corner as (x, y, bulge), as `Contour.vertices` gives it.
Vertex = tuple[float, float, float]


@dataclass(frozen=True)
class CuttingDrawing:
    """All that both files hold: cutting paths by layer and plate, the layers' colours, and what is engraved."""

    cuts: dict[str, dict[str, tuple[Contour, ...]]]
    colours: dict[str, tuple[int, str]]
    strokes: tuple[tuple[Point, ...], ...]
    size_mm: tuple[float, float]


def draw(plan: AcrylicPlan, kerf_mm: float) -> dict[str, CuttingDrawing]:
    """The drawings by their files' names, as `AcrylicPlan.drawings`: plates side by side above a scale bar."""
    colours = {_layer(stock): colour for stock, colour in zip(plan.stocks, CUTS, strict=False)}
    return {
        name: _lay([plate for plate in plan.plates if plate.stock in stocks], kerf_mm, colours)
        for name, stocks in plan.drawings.items()
    }


def _layer(stock: str) -> str:
    return f"CUT-{stock.upper()}"


def _lay(plates: Sequence[Plate], kerf_mm: float, colours: dict[str, tuple[int, str]]) -> CuttingDrawing:
    cuts: dict[str, dict[str, tuple[Contour, ...]]] = {}
    strokes = [((GAP_MM, GAP_MM), (GAP_MM + SCALE_MM, GAP_MM))]
    strokes += [
        ((GAP_MM + k, GAP_MM), (GAP_MM + k, GAP_MM + (4 if k % 50 == 0 else 2)))
        for k in range(0, int(SCALE_MM) + 1, 10)
    ]
    words = [(GAP_MM, GAP_MM + 6, f"{SCALE_MM:g} mm; kerf {kerf_mm:g} mm is in the paths")]
    x, floor = GAP_MM, GAP_MM + 5 * LETTERS_MM
    for plate in plates:
        paths = plate.cuts(kerf_mm)
        x0, y0, x1, y1 = paths[0].bounds
        cuts.setdefault(_layer(plate.stock), {})[plate.name] = tuple(p.moved(x - x0, floor - y0) for p in paths)
        words.append((x, floor - 1.4 * LETTERS_MM, f"{plate.name} {plate.stock.replace('-', ' ')}"))
        x, height = x + x1 - x0 + GAP_MM, y1 - y0
    lettered = [stroke for x0, y0, text in words for stroke in line_strokes(shape_line(text), LETTERS_MM, x0, y0)]
    width = max(x, GAP_MM + max(end for stroke in (*strokes, *lettered) for end, _ in stroke))
    kept = {layer: colours[layer] for layer in cuts}
    return CuttingDrawing(cuts, kept, (*strokes, *lettered), (width, floor + height + GAP_MM))


def check_cuts(plate: Plate, kerf_mm: float) -> None:
    """Check that some plate is left between any two burnt lines, and that only the first path has others inside.

    Raises: FabricationError where they do, or a corner has no room for the kerf.
    """
    manifold3d = cad_package("manifold3d")
    areas = [manifold3d.CrossSection([path.flat()]) for path in plate.cuts(kerf_mm)]
    # Half of what must lie between two paths, less a hundredth for the arcs' flat pieces.
    apart = (kerf_mm + LEAST_LAND_MM) / 2 - 0.01
    fat = [area.offset(apart, manifold3d.JoinType.Round) for area in areas[1:]]
    room = areas[0].offset(-apart, manifold3d.JoinType.Round)
    crossing = [k for k, area in enumerate(fat) if (area - room).area() > 1e-6]
    crossing += [k for k, area in enumerate(fat) for other in fat[:k] if (area ^ other).area() > 1e-6]
    if crossing:
        raise refused_drawing(
            "drawing",
            f"has paths of the {plate.name} that overlap or nearly meet",
            f"{LEAST_LAND_MM:g} mm between them",
        )


def check_found(what: str, found: dict[str, list[list[Vertex]]], drawing: CuttingDrawing) -> None:
    """Check that a file read back has each cutting path of the drawing once.  Raises: FabricationError."""
    if set(found) != set(drawing.cuts):
        raise refused_drawing(what, f"has the cutting layers {sorted(found)}", f"{sorted(drawing.cuts)}")
    for layer, plates in drawing.cuts.items():
        paths = [path for plate in plates.values() for path in plate]
        if len(found[layer]) != len(paths):
            raise refused_drawing(what, f"has {len(found[layer])} paths on {layer}", f"{len(paths)}")
        for got, path in zip(found[layer], paths, strict=True):
            wanted = path.vertices()
            pairs = zip(got, wanted, strict=False)
            if len(got) != len(wanted) or max(math.dist(a, b) for a, b in pairs) > ROUNDING_MM:
                raise refused_drawing(
                    what, f"has another path on {layer} than drawn", f"less than {ROUNDING_MM:g} mm off"
                )


#: The error of a drawing that failed its check.
refused_drawing = partial(refused, whose="acrylic parts'")


HAIRLINE_MM = 0.1


def write_dxf(drawing: CuttingDrawing, path: Path) -> None:
    """Write a DXF R2010 file, mm, alike in each run.  Raises: MissingExtraError without ezdxf."""
    ezdxf = cad_package("ezdxf", "a drawing for a cutter")
    # Without this the file would hold the time of writing, and the same badge would never give the same bytes.
    before, ezdxf.options.write_fixed_meta_data_for_testing = ezdxf.options.write_fixed_meta_data_for_testing, True
    try:
        document = ezdxf.new("R2010", units=ezdxf.units.MM)
        space = document.modelspace()
        for layer, plates in drawing.cuts.items():
            document.layers.add(layer, color=drawing.colours[layer][0])
            for contour in (path for plate in plates.values() for path in plate):
                space.add_lwpolyline(contour.vertices(), format="xyb", close=True, dxfattribs={"layer": layer})
        document.layers.add(ENGRAVED, color=ENGRAVE[0])
        for stroke in drawing.strokes:
            space.add_lwpolyline(stroke, dxfattribs={"layer": ENGRAVED})
        # ezdxf adds these in the order of a set, which changes from run to run.
        document.classes.add_required_classes(document.dxfversion)
        document.classes.classes = dict(sorted(document.classes.classes.items()))
        document.saveas(path)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def check_dxf(path: Path, drawing: CuttingDrawing) -> None:
    """Read a DXF file back: no faults in the audit, millimetres, closed paths where they were drawn, none over another.

    Raises: FabricationError with what was found and what is allowed.
    """
    ezdxf = cad_package("ezdxf", "a drawing for a cutter")
    try:
        document = ezdxf.readfile(path)
    except (OSError, ValueError, StopIteration, ezdxf.DXFError) as error:
        raise refused_drawing("DXF", "cannot be read back", "a readable file") from error
    audit = document.audit()
    # A fault that ezdxf repairs on reading counts too, because another program may not repair it.
    if faults := [*audit.errors, *audit.fixes]:
        raise refused_drawing("DXF", f"has {len(faults)} faults in its audit ({faults[0].message})", "none")
    if document.units != ezdxf.units.MM:
        raise refused_drawing("DXF", f"counts in unit {document.units}", "millimetres (4)")
    found: dict[str, list[list[Vertex]]] = {}
    for entity in document.modelspace():
        layer = entity.dxf.layer
        if not layer.startswith("CUT-"):
            continue
        if entity.dxftype() != "LWPOLYLINE" or not entity.closed:
            raise refused_drawing("DXF", f"has an open path on {layer}", "closed polylines alone")
        colour, wanted = document.layers.get(layer).color, drawing.colours.get(layer, ENGRAVE)[0]
        if colour != wanted:
            raise refused_drawing("DXF", f"shows {layer} in colour {colour}", f"{wanted}")
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
    for layer, plates in drawing.cuts.items():
        paths = (
            f'<path id={quoteattr(plate)} d="{" ".join(_svg_path(path.vertices(), height) for path in own)}"/>'
            for plate, own in plates.items()
        )
        lines.append(_svg_group(layer, drawing.colours[layer][1], "".join(paths)))
    engraved = " ".join(f"M {' L '.join(f'{x:.3f} {height - y:.3f}' for x, y in stroke)}" for stroke in drawing.strokes)
    lines.append(_svg_group(ENGRAVED, ENGRAVE[1], f'<path d="{engraved}"/>'))
    path.write_text("\n".join([*lines, "</svg>", ""]), encoding="utf-8")


def check_svg(path: Path, drawing: CuttingDrawing) -> None:
    """Read an SVG file back: its size in mm, and the same closed paths as were drawn, each in its layer's colour.

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
            if group.id in drawing.colours and drawn.stroke == drawing.colours[group.id][1]:
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
