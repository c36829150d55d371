"""The stability suite, with its table and plot: stiff and extreme cases.

Each must be read correctly, or be called unreadable with the reason; never wrongly.  One clip a case, made to be at the
edge of what a badge, its building or its picture can be, and beyond it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from moireid.badge import Badge, Rect
from moireid.designer import Order, design_badge
from moireid.question import KnownCamera, Question
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier.session.film import verify
from moireid.verifier.session.result import Report
from moireid_lab.bench.bench_frame import Bench, Row, Wish, temporary_film
from moireid_lab.bench.bench_plots import figure_of, plain
from moireid_lab.bench.identity.clips import CRF, FOCAL_PX, FPS
from moireid_lab.bench.simulate.stiff_scenes import run_scenes

Outcome = Literal["right", "unreadable", "refused", "wrong"]
PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES, QUICK_FRAMES = 150, 90


@dataclass(frozen=True)
class StabilityCase:
    """One case: how the badge is made, built and filmed.

    beat: share of the reference row's designed beat that is left, made by a sheet of another pitch; hidden: part of
    the board that is covered, as shares of its width and height; contrast: of the print, (paper - ink)/(paper + ink).
    """

    name: str
    request: Order = field(default_factory=lambda: Order("Bench", lens="50lpi"))
    payload: bytes = PAYLOAD
    twist_deg: float = 0.1
    beat: float = 1.0
    hidden: tuple[float, float, float, float] | None = None
    contrast: float | None = None
    distance_m: float = 1.4
    motion: str = "sway"


def cases() -> list[StabilityCase]:
    """All cases; each group begins with one that must be read."""
    small, large = (
        Order("Bench", lens="50lpi", size_mm=(96.0, 110.0), range_m=(0.5, 0.9)),
        Order("Bench", lens="50lpi", size_mm=(186.0, 273.0)),
    )
    return [
        *(
            StabilityCase(f"beat at {100 * share:g} % of the design", beat=share)
            for share in (0.9, 0.5, 0.2, 0.0, -0.5, -1.0)
        ),
        *(StabilityCase(f"twist {degrees:g} degrees", twist_deg=degrees) for degrees in (0.3, 0.45, 0.7, 1.5, 5.0)),
        *(
            StabilityCase(
                f"twist 1.2 degrees, {axes}", Order("Bench", lens="50lpi", axes=axes, range_m=(0.8, 2.0)), twist_deg=1.2
            )
            for axes in ("xy", "hex")
        ),
        StabilityCase("smallest board, 0.7 m", small, distance_m=0.7),
        StabilityCase("largest board", Order("Bench", lens="50lpi", size_mm=large.size_mm, range_m=(1.2, 2.5))),
        StabilityCase("quarter hidden, a corner", hidden=(0.0, 0.0, 0.5, 0.5)),
        StabilityCase("quarter hidden, the right edge", hidden=(0.75, 0.0, 1.0, 1.0)),
        StabilityCase("quarter hidden, the middle", hidden=(0.25, 0.25, 0.75, 0.75)),
        StabilityCase("quarter hidden, the top", hidden=(0.0, 0.0, 1.0, 0.25)),
        *(StabilityCase(f"print contrast {100 * c:g} %", contrast=c) for c in (0.2, 0.1, 0.05, 0.02)),
        *(StabilityCase(f"distance {metres:g} m", distance_m=metres) for metres in (0.6, 3.0, 4.0, 6.0)),
        StabilityCase("no motion", motion="static"),
        StabilityCase("payload of zeros", payload=bytes(8)),
        StabilityCase("payload of ones", payload=b"\xff" * 8),
    ]


def rows(wish: Wish) -> Iterator[Row]:
    """All cases, or those that are asked for; then scenes that renderers find hard."""
    frames = QUICK_FRAMES if wish.quick else FRAMES
    yield from wish.each(read_case, {case.name: (case, wish.seed, frames) for case in cases()})
    if wish.only is None:
        yield from run_scenes()


def read_case(job: tuple[StabilityCase, int, int]) -> Row:
    """Film one case and read it."""
    case, seed, frames = job
    badge = design_badge(case.request, case.payload)
    grating = badge.gratings[0]
    designed = 1 / grating.pitch_mm - 1 / badge.lens.pitch_mm
    lens_scale = 1 / (badge.lens.pitch_mm * (1 / grating.pitch_mm - case.beat * designed))
    build = Build(0.17, math.radians(case.twist_deg), 1.001, 1.001 * lens_scale)
    camera = Camera(1280, 720, FOCAL_PX)
    scene = Scene(badge, build, camera, hidden_mm=_part_of(badge, case.hidden))
    if case.contrast is not None:
        scene = replace(scene, paper=0.5, ink=0.5 * (1 - case.contrast) / (1 + case.contrast))
    motion = motion_named(case.motion, distance_mm=1000 * case.distance_m, seed=seed)
    with temporary_film(scene, motion, frames=frames, fps=FPS, seed=seed, crf=CRF) as video:
        report = verify(video, Question(badge, badge.id, camera=KnownCamera(FOCAL_PX)))
    return {
        "name": case.name,
        "outcome": outcome_of(report, badge, case.beat),
        "verdict": report.verdict,
        "why": _why(report),
        "symbols_corrected": report.identity.symbol_errors_corrected,
        "tracked": report.track.tracked,
        "frames": frames,
        "seconds": report.timing["total_s"],
    }


def outcome_of(report: Report, badge: Badge, beat: float) -> Outcome:
    """Right: the identity was read, and a true film not rejected; unreadable: inconclusive; wrong: anything else.

    Refused: if a badge's beat is zero or has the wrong sign, its fringes move against the law, just like those of a
    reversed forgery.  The film shows no difference between the two, so it is rightly rejected.
    """
    if report.identity.decoded_id not in (None, badge.id):
        return "wrong"
    if report.verdict == "reject":
        return "refused" if beat <= 0 else "wrong"
    return "right" if report.identity.decoded_id == badge.id else "unreadable"


def _why(report: Report) -> str:
    """The reason for which the film is inconclusive or rejected, if it was."""
    open_ = [reason.text for reason in report.reasons if reason.level in ("fail", "undecided")]
    return open_[0] if open_ else ""


def _part_of(badge: Badge, shares: tuple[float, float, float, float] | None) -> Rect | None:
    """A part of the board, page mm."""
    if shares is None:
        return None
    x0, y0, x1, y1 = badge.outline_mm
    left, top, right, bottom = shares
    return (x0 + left * (x1 - x0), y0 + top * (y1 - y0), x0 + right * (x1 - x0), y0 + bottom * (y1 - y0))


COLUMNS = {"case": "name <36", "renderer on": "scene <38", "outcome": "<11", "verdict": "<13"}
COLUMNS |= {"fixed": "symbols_corrected >6", "tracked": ">8", "frames": ">7"}
COLUMNS |= {"phase, rad (bar)": ">18", "image (bar)": ">17", "why": "<1"}


def table(rows: list[Row]) -> Iterator[Row]:
    """The cases, and the scenes with their error bars."""
    for row in rows:
        bars = {"phase, rad (bar)": ("phase_rad", "bar_rad"), "image (bar)": ("image", "bar_image")}
        yield row | ({name: _with_bar(row, *keys) for name, keys in bars.items()} if "scene" in row else {})


def _with_bar(row: dict[str, Any], figure: str, bar: str) -> str:
    """A figure and its error bar, or a dash."""
    return "-" if row.get(figure) is None else f"{row[figure]:.4f} ({row[bar]:.4f})"


def plot(rows: list[Row]) -> Any:
    """One bar a case: frames in which the badge was followed, coloured by outcome."""
    rows = [row for row in rows if "scene" not in row][::-1]
    colours = {"right": "#2e7d4f", "unreadable": "#8a97a6", "refused": "#c9a227", "wrong": "#c0392b"}
    figure = figure_of(7, 0.24 * len(rows) + 1)
    axes = figure.add_subplot()
    for outcome, colour in colours.items():
        some = [(k, row["tracked"] / row["frames"]) for k, row in enumerate(rows) if row["outcome"] == outcome]
        axes.barh([k for k, _ in some], [share for _, share in some], color=colour, label=f"{outcome}: {len(some)}")
    axes.set_yticks(range(len(rows)), [row["name"] for row in rows], fontsize=8)
    axes.set_xlabel("share of frames in which the badge was followed")
    axes.legend(frameon=False, ncols=4, loc="lower left", bbox_to_anchor=(0, 1))
    plain(axes)
    return figure


BENCH = Bench(rows, COLUMNS, table=table, plot=plot)
