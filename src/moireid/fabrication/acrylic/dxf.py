"""acrylic.dxf: the laser's drawing for CAM programs, AutoCAD R2010, in millimetres, y up."""

from __future__ import annotations

from pathlib import Path

from moireid.fabrication.acrylic.cutting import CUT, ENGRAVE, NOTE, TEXT_MM, Drawing, Vertex, check_found, refused
from moireid.fabrication.solids import cad_package


def write_dxf(drawing: Drawing, path: Path) -> None:
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


def check_dxf(path: Path, drawing: Drawing, kerf_mm: float) -> None:
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
