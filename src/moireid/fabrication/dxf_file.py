"""Drawings for a cutter as DXF: written alike in each run, and read back.

Source: ezdxf; DXF R2010, units of mm.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from moireid.errors import FabricationError
from moireid.fabrication.solids import cad_package


@contextmanager
def written_dxf(path: Path) -> Iterator[Any]:
    """Yield an empty ezdxf document, mm, which is written to `path` at the end.

    Raises: MissingExtraError without ezdxf.
    """
    ezdxf = cad_package("ezdxf", "a drawing for a cutter")
    before = ezdxf.options.write_fixed_meta_data_for_testing
    # Without this the file would hold the time of writing, and the same badge would never give the same bytes.
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        document = ezdxf.new("R2010", units=ezdxf.units.MM)
        yield document
        # ezdxf adds these in the order of a set, which changes from run to run.
        document.classes.add_required_classes(document.dxfversion)
        document.classes.classes = dict(sorted(document.classes.classes.items()))
        document.saveas(path)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def sound_dxf(path: Path, refused: Callable[[str, str], FabricationError]) -> Any:
    """Read a DXF file back as an ezdxf document: no faults in the audit, millimetres.

    Raises: what `refused` makes of what was found and what is allowed.
    """
    ezdxf = cad_package("ezdxf", "a drawing for a cutter")
    try:
        document = ezdxf.readfile(path)
    except (OSError, ValueError, StopIteration, ezdxf.DXFError) as error:
        raise refused("cannot be read back", "a readable file") from error
    audit = document.audit()
    # A fault that ezdxf repairs on reading counts too, because another program may not repair it.
    if faults := [*audit.errors, *audit.fixes]:
        raise refused(f"has {len(faults)} faults in its audit ({faults[0].message})", "none")
    if document.units != ezdxf.units.MM:
        raise refused(f"counts in unit {document.units}", "millimetres (4)")
    return document
