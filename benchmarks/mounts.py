"""What it takes to print each part of each mount: run `moireid lab bench mounts [--only KIND]`.

Each part is sliced by PrusaSlicer as for a common printer (a bed of 250 x 210 mm, a 0.4 mm nozzle, layers of 0.2 mm,
PLA), once plain and once with supports wherever the slicer asks for them below 44 degrees from level.  Printed are the
time, the plastic, how much of it supports would be, and the area of faces that hang in the air as `overhang_mm2` has
it.  Formats are those of people's holders; where a mount cannot be made for one, its row gives the reason.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import trimesh

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import MoireIdError
from moireid.fabrication.printed.mount import KINDS, write_mount
from moireid.fabrication.solids import overhang_mm2
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.bench_rows import chosen_names

#: Width and height in mm, sheet, range in m.
FORMATS = {
    "cr80": ((85.6, 54.0), "75lpi-18mil", (0.2, 0.4)),
    "a7": ((105.0, 74.0), "75lpi-18mil", (0.3, 0.5)),
    "4x3in": ((101.6, 76.2), "75lpi-18mil", (0.3, 0.5)),
    "a6": ((148.0, 105.0), "62lpi-27mil", (0.4, 0.8)),
    "a5": ((210.0, 148.0), "50lpi", (0.6, 2.0)),
    "webcam": ((150.0, 120.0), "50lpi", (0.4, 0.9)),
    "board": ((146.0, 160.0), "50lpi", (0.8, 2.5)),
}
PRINTER = {
    "layer-height": "0.2",
    "nozzle-diameter": "0.4",
    "filament-diameter": "1.75",
    "filament-density": "1.24",
    "perimeters": "3",
    "fill-density": "15%",
    "skirts": "0",
    "bed-shape": "0x0,250x0,250x210,0x210",
}
SUPPORTS = ("--support-material", "--support-material-auto", "--support-material-threshold", "44")


def sliced(stl: Path, *more: str) -> tuple[float, str]:
    """Filament in g and the time that the slicer reports.  Raises: CalledProcessError where it fails."""
    gcode = stl.with_suffix(".gcode")
    options = [word for name, value in PRINTER.items() for word in (f"--{name}", value)]
    command = ["prusa-slicer", "--export-gcode", *options, *more, "--output", str(gcode), str(stl)]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    text = gcode.read_text()
    length = sum(map(float, re.findall(r"filament used \[mm\] = ([\d.]+)", text)))
    time = re.search(r"estimated printing time \(normal mode\) = (.+)", text)
    return length * 3.14159 * 0.875**2 * 1.24e-3, time.group(1).strip() if time else "?"


def figures_of(badge: Badge, kind: str, folder: Path) -> Iterator[Row]:
    """The figures of one mount's parts."""
    report = write_mount(badge, folder, kind=kind)
    for stl, body in zip(report.stls, report.bodies, strict=True):
        (plain_g, time), (held_g, _) = sliced(stl), sliced(stl, *SUPPORTS)
        sides = zip(body.lower_mm, body.upper_mm, strict=True)
        yield {
            "part": body.name,
            "on the bed, mm": " x ".join(f"{high - low:.0f}" for low, high in sides),
            "time": time,
            "PLA, g": plain_g,
            "supports, g": held_g - plain_g,
            "hangs, mm2": overhang_mm2(trimesh.load_mesh(stl)),
        }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a format, mount and part."""
    wanted = chosen_names([f"{name} {kind}" for name in FORMATS for kind in KINDS], wish.only)
    for one in wanted:
        name, kind = one.split()
        size_mm, lens, range_m = FORMATS[name]
        with tempfile.TemporaryDirectory() as folder:
            row: Row = {"format": name, "mount": kind}
            try:
                badge = design_badge(Order("Bench", lens=lens, size_mm=size_mm, range_m=range_m), bytes(8))
                yield from (row | part for part in figures_of(badge, kind, Path(folder)))
            except MoireIdError as error:
                yield row | {"refused": str(error)}


COLUMNS = {
    "format": "<7",
    "mount": "<8",
    "part": "<7",
    "on the bed, mm": "<17",
    "time": ">11",
    "PLA, g": ">7.1f",
    "supports, g": ">12.1f",
}
COLUMNS |= {"hangs, mm2": ">13.2f", "refused": "<1"}
BENCH = Bench(rows, COLUMNS)
