"""What it takes to print each mount: run `.venv/bin/python benchmarks/mounts.py [--only KIND] [--pictures FOLDER]`.

With --table, the rows that are printed replace those of `src/moireid/fabrication/printing_times.py`.

Each mount is sliced by PrusaSlicer as for a common printer (a 0.4 mm nozzle, layers of 0.2 mm, PLA), once plain and
once with supports wherever the slicer asks for them below 44 degrees from level.  Printed are the time, the plastic,
how much of it supports would be, and the area of faces that hang in the air as `overhang_mm2` has it; of a snap-in
holder also the strain of a catch as the badge passes, and the force that pushes a badge out.  Formats are those of
people's holders; where a mount cannot be made for one, its row gives the reason.

With --pictures, each mount is also drawn as it lies on the bed, seen from above and from below.
"""

from __future__ import annotations

import ast
import re
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import trimesh

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.errors import MoireIdError
from moireid.fabrication.printed.mount import KINDS, write_mount
from moireid.fabrication.solids import overhang_mm2
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

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
    "bed-shape": "0x0,350x0,350x350,0x350",
}
TABLE = Path(__file__).parents[1] / "src/moireid/fabrication/printing_times.py"
TABLE_HEAD = '''"""Printing time and plastic of each mount, written by `benchmarks/mounts.py --table`, which says how.

The whole mount, clip or stand included: PLA, a nozzle of 0.4 mm, layers of 0.2 mm, three outlines, and the speeds that
PrusaSlicer has without a printer's profile.
"""

#: Minutes and grams, by format and kind of the printed mount.
PRINTING_TIMES: dict[tuple[str, str], tuple[int, float]] = {
'''
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


def minutes_of(time: str) -> int:
    """A slicer's "1h 5m 28s" in minutes, rounded up."""
    parts = {unit: int(number) for number, unit in re.findall(r"(\d+)([hms])", time)}
    return 60 * parts.get("h", 0) + parts.get("m", 0) + (1 if parts.get("s") else 0)


def write_table(found: list[Row]) -> None:
    """Write the times and masses of the rows, and of those that the table has already, as a module."""
    # Read from the file, as another run may have written it since.
    times = ast.literal_eval(TABLE.read_text(encoding="utf-8").rpartition("]] = ")[2])
    times |= {(str(r["format"]), str(r["mount"])): (minutes_of(str(r["time"])), round(r["PLA, g"], 1)) for r in found}
    order = [(name, kind) for name in FORMATS for kind in KINDS if (name, kind) in times]
    lines = [f'    ("{name}", "{kind}"): {times[name, kind]},\n' for name, kind in order]
    TABLE.write_text(TABLE_HEAD + "".join(lines) + "}\n", encoding="utf-8")


def figures_of(badge: Badge, kind: str, folder: Path) -> Row:
    """One mount's figures."""
    report = write_mount(badge, folder, kind=kind)
    (plain_g, time), (held_g, _) = sliced(report.stl), sliced(report.stl, *SUPPORTS)
    return {
        "on the bed, mm": " x ".join(f"{side:.0f}" for side in report.size_mm),
        "time": time,
        "PLA, g": plain_g,
        "supports, g": held_g - plain_g,
        "hangs, mm2": sum(overhang_mm2(piece) for piece in trimesh.load_mesh(report.stl).split()),
        "strain, %": 100 * report.figures["strain"] if kind == "holder" else None,
        "out, N": report.figures["hold_n"] if kind == "holder" else None,
    }


def draw(stl: Path, path: Path) -> None:
    """The bodies as they lie on the bed, from above and from below."""
    from matplotlib.colors import LightSource
    from matplotlib.figure import Figure

    mesh = trimesh.load_mesh(stl)
    figure = Figure(figsize=(12, 6))
    for number, (rise, words) in enumerate(((35, "from above"), (-35, "from below"))):
        axes: Any = figure.add_subplot(1, 2, number + 1, projection="3d")
        axes.plot_trisurf(
            *mesh.vertices.T, triangles=mesh.faces, color="#9fc3e8", lightsource=LightSource(315, 45), linewidth=0
        )
        axes.set_box_aspect(tuple(mesh.extents))
        axes.view_init(rise, -60)
        axes.set_axis_off()
        axes.set_title(words)
    figure.savefig(path, dpi=80)


def rows(wish: Wish) -> Iterator[Row]:
    """One row a format and mount."""
    found: list[Row] = []
    pictures, wanted = wish.own.pictures, wish.chosen(f"{name} {kind}" for name in FORMATS for kind in KINDS)
    for one in wanted:
        name, kind = one.split()
        size_mm, lens, range_m = FORMATS[name]
        with tempfile.TemporaryDirectory() as folder:
            row: Row = {"format": name, "mount": kind}
            try:
                badge = design_badge(Request("Bench", lens=lens, size_mm=size_mm, range_m=range_m), bytes(8))
                row |= figures_of(badge, kind, Path(folder))
                found.append(row)
                yield row
            except MoireIdError as error:
                yield row | {"refused": str(error)}
                continue
            if pictures:
                pictures.mkdir(exist_ok=True)
                draw(Path(folder) / "mount.stl", pictures / f"{name}-{kind}.png")
    if wish.own.table:
        write_table(found)


COLUMNS = {
    "format": "<7",
    "mount": "<8",
    "on the bed, mm": "<17",
    "time": ">11",
    "PLA, g": ">7.1f",
    "supports, g": ">12.1f",
}
COLUMNS |= {"hangs, mm2": ">13.2f", "strain, %": ">11.2f", "out, N": ">8.1f", "refused": "<1"}
OPTIONS = {
    "--pictures": {"type": Path, "help": "folder for a picture of each mount"},
    "--table": {"action": "store_true", "help": "write these rows into the module of printing times"},
}
BENCH = Bench(rows, COLUMNS, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
