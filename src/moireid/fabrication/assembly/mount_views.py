"""The parts of a mount in the exploded views, with card and sheet, from behind to the front.

Convention: the frame of `sight`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from moireid.badge import Badge, Point
from moireid.fabrication.acrylic.plates import NUT_MM, AcrylicPlan
from moireid.fabrication.assembly.exploded import (
    GAP,
    Loop,
    Part,
    Piece,
    card_part,
    front_parts,
    plain_parts,
    prism,
    project,
)
from moireid.fabrication.printed.mount import MountPlan
from moireid.fabrication.process_figures import MountProcess

#: Gaps other than the usual one: screws need less; a clip and a tab need more, because the parts before them would hide
#: them.
SCREW_GAP, CLIP_GAP, TAB_GAP = 0.25, 1.05, 0.8
#: Across an M3 nut's corners, ISO 4032.
NUT_WIDE_MM = 6.35


def printed_parts(badge: Badge, mount: MountPlan, process: MountProcess, drawn: Mapping[str, Piece]) -> list[Part]:
    """The printed mount with card and front; drawn: its solids, as `solid_views.drawn_solids` gives them."""
    plan, second = mount
    tab = TAB_GAP if plan.slots else GAP
    behind = []
    if second:
        gap = CLIP_GAP if second.name == "clip" else GAP
        body = (drawn[second.name],)
        behind = [Part(f"{second.name}, 3D-printed", f"{second.width_mm:g} mm wide", body, 0.88, gap=gap, alone=True)]
    size = f"{plan.lip_top + process.back_mm:.1f} mm deep, back {process.back_mm:g} mm"
    return [*behind, Part("tray, 3D-printed", size, (drawn["tray"],), 0.88, gap=tab), *plain_parts(badge, process)]


def acrylic_parts(
    badge: Badge, plan: AcrylicPlan, film_mm: float, screw: str, drawn: Mapping[str, Piece]
) -> list[Part]:
    """The acrylic stack, nuts and screws.

    Parameters: screw: what to call the screws' size; drawn: its solids, as `solid_views.drawn_solids` gives them.
    """
    count, bottom = len(plan.screws), plan.base.low_mm
    nuts = tuple(prism(_hexagon(at), bottom - NUT_MM, bottom) for at in plan.screws)
    # The screws farther from the viewer come first, because the nearer ones cover them.
    far_first = sorted(range(count), key=lambda k: project((*plan.screws[k], 0.0))[1], reverse=True)
    screws = tuple(drawn[f"screw-{k}"] for k in far_first)
    plates = {
        plate.name: Part(
            f"acrylic {plate.name}" if plate.name != "lips" else "lips of film",
            f"{plate.thickness_mm:g} mm",
            (drawn[plate.name],),
            0.93,
            screws=plan.screws,
        )
        for plate in plan.plates
    }
    base, *frames, lips, cover = plates.values()
    words = f"{plan.layers} {'layer' if plan.layers == 1 else 'layers'} of card"
    pad = [Part(words, f"{plan.pad_mm:.1f} mm together", (drawn["pad"],), 0.97)] if plan.layers else []
    held = [card_part(badge, plan.card_mm), *front_parts(badge, plan.card_mm, film_mm)]
    below = Part(f"{count} nuts", "M3", nuts, 0.75, gap=SCREW_GAP, screws=plan.screws)
    above = Part(f"{count} screws", screw, screws, 0.75, gap=SCREW_GAP, screws=plan.screws)
    return [below, base, *frames, *pad, *held, lips, cover, above]


def _hexagon(centre: Point) -> Loop:
    angles = [math.pi * k / 3 for k in range(6)]
    return tuple((centre[0] + NUT_WIDE_MM / 2 * math.cos(a), centre[1] + NUT_WIDE_MM / 2 * math.sin(a)) for a in angles)
