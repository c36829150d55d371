"""Mounts at their extremes: which are made completely, which in part, and what a refusal advises.

Every case is planned, which takes milliseconds and refuses what cannot be; a few are built with all their files, each
of which is read back and checked.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from moireid.badge import Badge, Lens
from moireid.designer import Order, design_badge
from moireid.errors import MoireIdError
from moireid.fabrication.mount_parts import Parts, plan_parts, write_parts
from moireid.fabrication.process_figures import mount_figures
from moireid.profiles import LensProfile, lens_named, save_lens_profile
from moireid_lab.bench.bench_frame import Row, grouped

KINDS = ("lanyard", "clip", "stand", "holder")
PAYLOAD = bytes(range(8))
#: A lens that is as thick as its focal length is at most 0.72 of that wide, at the refractive index of 1.56.
THIN_PITCH_SHARE = 0.7


@dataclass(frozen=True)
class MountCase:
    """One extreme: its name, the wish for a badge, the lens sheet's thickness where it is no label's, mount figures."""

    name: str
    request: Order
    lens_mm: float | None = None
    figures: Mapping[str, float] = field(default_factory=dict)


def cases() -> list[MountCase]:
    """Boards, sheets, spacers and kerfs at and beyond what can be made, for either front layer."""
    # The smallest board has room for two letters.
    plain = Order("Ex", lens="50lpi")
    found = []
    for front in ("lens", "mask"):
        base = replace(plain, front=front)
        # A small badge is filmed from near.
        for size, range_m in (
            ((30.0, 30.0), (0.3, 0.5)),
            ((30.0, 40.0), (0.3, 0.5)),
            ((60.0, 66.0), (0.5, 0.7)),
            ((146.0, 160.0), plain.range_m),
            ((186.0, 273.0), plain.range_m),
            ((300.0, 300.0), plain.range_m),
        ):
            name = f"board {size[0]:g}x{size[1]:g} mm"
            found.append(MountCase(name, replace(base, size_mm=size, range_m=range_m)))
        for kerf in (0.0, 1.0, 5.0):
            found.append(MountCase(f"kerf {kerf:g} mm", base, figures={"kerf_mm": kerf}))
    # A thin sheet also has narrow lenses, so it needs a fine printer and a near camera.
    fine = replace(plain, printer_dpi=4800, range_m=(0.4, 1.2))
    found += [MountCase(f"sheet {lens_mm:g} mm", fine, lens_mm) for lens_mm in (0.2, 0.3)]
    found += [MountCase(f"sheet {lens_mm:g} mm", plain, lens_mm) for lens_mm in (2.5, 4.0, 6.0)]
    masks = replace(plain, front="mask")
    found += [
        MountCase(f"spacer {gap:g} mm", replace(masks, lens_thickness_mm=gap)) for gap in (0.2, 0.5, 1.5, 3.0, 6.0)
    ]
    return found


#: Cases that are built, by name, front layer and mount.
BUILT = (
    ("board 30x40 mm", "lens", "clip"),
    ("sheet 6 mm", "lens", "lanyard"),
    ("sheet 0.2 mm", "lens", "stand"),
    ("spacer 3 mm", "mask", "stand"),
    ("board 186x273 mm", "mask", "lanyard"),
    ("kerf 1 mm", "lens", "clip"),
    ("board 60x66 mm", "lens", "holder"),
    ("spacer 0.5 mm", "mask", "holder"),
)


def extremes(built: Collection[tuple[str, str, str]] = BUILT) -> list[dict[str, Any]]:
    """A row for each case and mount: outcome, why anything is missing, and whether it was built.

    Parameters: built: which are built and not only planned, by case, front layer and mount.
    Returns: outcome "whole", "printed" or "acrylic" (that alone), or "refused"; seconds of the planning, and of the
        building where that was done.
    """
    return [row(case, kind, build=(case.name, case.request.front, kind) in built) for case in cases() for kind in KINDS]


def row(case: MountCase, kind: str, *, build: bool) -> dict[str, Any]:
    """What becomes of one case with one mount.  Raises: FabricationError where what was planned fails its checks."""
    found: dict[str, Any] = {"case": case.name, "front": case.request.front, "mount": kind}
    clock = time.perf_counter()
    try:
        badge, parts = planned_case(case, kind)
    except MoireIdError as error:
        return found | {"outcome": "refused", "why": str(error), "built": False}
    found |= {"plan_ms": 1e3 * (time.perf_counter() - clock), "built": build}
    if build:
        clock = time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            write_parts(badge, parts, Path(folder), lambda name: None)
        found["build_s"] = time.perf_counter() - clock
    return found | {"outcome": outcome_of(parts), "why": "; ".join(parts.left_out.values())}


def planned_case(case: MountCase, kind: str) -> tuple[Badge, Parts]:
    """The badge of a case, and what is made of its mount.  Raises: MoireIdError where it is refused."""
    figures = mount_figures(case.figures)
    with tempfile.TemporaryDirectory() as folder:
        request = case.request
        if case.lens_mm is not None:
            path = Path(folder) / "sheet.json"
            nominal = lens_named(str(request.lens))
            pitch_mm = min(nominal.pitch_mm, THIN_PITCH_SHARE * case.lens_mm)
            lens = Lens("lenticular", pitch_mm, case.lens_mm, nominal.refractive_index)
            save_lens_profile(LensProfile(case.name, lens, 1e-4), path)
            request = replace(request, lens=str(path))
        badge = design_badge(request, PAYLOAD)
    return badge, plan_parts(badge, kind, figures)


def outcome_of(parts: Parts) -> str:
    """Which of the two mounts is made: both, or the one that is named."""
    if not parts.left_out:
        return "whole"
    return "printed" if parts.printed != "none" else "acrylic"


COLUMNS = {"mount at its extreme": "<21", "front": "<7", **dict.fromkeys(KINDS, "<10"), "why not whole": "<1"}


def extremes_table(rows: list[Row]) -> Iterator[Row]:
    """A row a case, with the outcome for each mount (an asterisk where it was built and checked), and why."""
    for (case, front), group in grouped(rows, "case", "front").items():
        marks = {entry["mount"]: entry["outcome"] + "*" * entry["built"] for entry in group}
        why = " | ".join(dict.fromkeys(entry["why"] for entry in group if entry["why"]))
        yield {"mount at its extreme": case, "front": front} | marks | {"why not whole": why}
