"""The reality suite, with its table: films as phones, editors, calls and services change them.

Each effect at each strength is filmed at 1 m and 2 m, of a true badge and of forged ones.  The table shows how many
films are accepted, inconclusive or rejected, with gain, residual and run time.

Convention: a film is judged by `verify` with the badge as claim and its identity, not known as built.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from moireid.designer import Order, design_badge
from moireid.simulate.effects.table import KINDS, STRENGTHS, effect_named
from moireid.simulate.motion import Motion, motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, counted_verdicts, grouped, temporary_film
from moireid_lab.bench.verdicts import verdict_row

#: The first row: a film to which nothing was done.
NOTHING = "none"
DISTANCES_M = (1.0, 2.0)
FORGERIES = ("gain_low", "wobble", "drift", "reversed")
#: Of a true badge.
TRUE = "true"


@dataclass(frozen=True)
class EffectCase:
    """effect: of `simulate.effects`, or none; badge: "true", or the kind of the forgery."""

    effect: str
    strength: str
    distance_m: float
    badge: str

    @property
    def name(self) -> str:
        """As `--only` matches it and rows are kept by it."""
        return f"{self.effect}:{self.strength} {self.distance_m:g} m {self.badge}"


def cases() -> list[EffectCase]:
    """All of them, true ones first, the ordinary strength before the others."""
    order = sorted(STRENGTHS, key=lambda strength: strength != "ordinary")
    some = [(NOTHING, "ordinary")] + [(effect, strength) for strength in order for effect in KINDS]
    return [
        EffectCase(effect, strength, distance, badge)
        for badge in (TRUE, *FORGERIES)
        for effect, strength in some
        for distance in DISTANCES_M
    ]


def usual(case: EffectCase, *, quick: bool) -> bool:
    """Whether a case is filmed unless asked for by name: forged ones at the ordinary strength alone; quick: the true
    badge at the ordinary strength, at 1 m.
    """
    if quick:
        return case.badge == TRUE and case.strength == "ordinary" and case.distance_m == DISTANCES_M[0]
    return case.badge == TRUE or case.strength == "ordinary"


PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES, FPS = 240, 30.0
MOTIONS = ("sway", "handheld", "linear")
CAMERA = Camera(1280, 720, 966.7)


def motion_of(case: EffectCase, seed: int) -> Motion:
    """By the seed: a body that sways before a camera on a tripod, a hand-held camera, or one moved to and fro."""
    return motion_named(MOTIONS[seed % len(MOTIONS)], distance_mm=1000 * case.distance_m, seed=seed)


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case, judged."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = design_badge(Order("Bench", lens="50lpi"), PAYLOAD)
    scene = Scene(badge, Build.typical(seed), CAMERA)
    how = {
        "forge": None if case.badge == TRUE else case.badge,
        "effects": [] if case.effect == NOTHING else [effect_named(f"{case.effect}:{case.strength}")],
    }
    with temporary_film(scene, motion_of(case, seed), frames=frames, fps=FPS, seed=seed, **how) as video:
        clock = time.perf_counter()
        report = verify(video, Question(badge, badge.id))
        seconds = time.perf_counter() - clock
    row = {"effect": case.effect, "strength": case.strength, "distance_m": case.distance_m, "badge": case.badge}
    motion = report.invariant
    lens = report.measurement.camera if report.measurement else None
    row |= {"focal_px": lens.focal_px, "axis_px": lens.axis_px, "aspect": lens.aspect} if lens else {}
    more = {"gain_sd": motion.gain_sd, "residual_rad": motion.phase_residual_rad, "tracked": report.frames["tracked"]}
    return row | {"seed": seed, "frames": frames, "seconds": seconds} | verdict_row(report) | more


def rows(wish: Wish) -> Iterator[Row]:
    """The usual films, or those that are asked for.  Raises: SpecError where no case is left."""
    names = [case.name for case in cases() if wish.only is not None or usual(case, quick=wish.quick)]
    return wish.films(run_case, names, FRAMES, wish.seeds(10))


VERDICT_COLUMNS = {"accept": ">8", "inconclusive": ">13", "reject": ">8"}
FIGURE_COLUMNS = {"gain error": ">12.3f", "residual": ">10.3f", "s a film": ">10.1f", "reasons": "<1"}
COLUMNS = {"true badge": "<34", "forged badge": "<34"} | VERDICT_COLUMNS | FIGURE_COLUMNS


def table(rows: list[Row]) -> Iterator[Row]:
    """Verdicts, gain error, residual and time of every effect, strength and distance; then the forged films."""
    for true in (True, False):
        for key, films in groups(rows, true=true).items():
            yield _figures(f"{'true' if true else 'forged'} badge", key, films)


def groups(rows: list[Row], *, true: bool) -> dict[tuple[str, str, float], list[Row]]:
    """Rows by effect, strength and distance, in the order of the effects; forged ones of all kinds together."""
    own = [row for row in rows if (row["badge"] == TRUE) == true]
    effects = [NOTHING, *KINDS]
    return dict(
        sorted(
            grouped(own, "effect", "strength", "distance_m").items(),
            key=lambda one: (effects.index(one[0][0]), STRENGTHS.index(one[0][1]), one[0][2]),
        )
    )


def summary(rows: list[Row]) -> list[str]:
    """Shares at the ordinary strength: of the true films accepted and rejected, of the forged ones accepted."""
    rows = [row for row in rows if row["strength"] == "ordinary" and row["effect"] != NOTHING]
    lines = []
    for true in (True, False):
        verdicts = Counter(row["verdict"] for row in rows if (row["badge"] == TRUE) == true)
        if count := sum(verdicts.values()):
            shares = ", ".join(f"{verdict} {verdicts[verdict]}" for verdict in VERDICT_COLUMNS)
            lines.append(f"{'true' if true else 'forged'} films at ordinary strength: {count} ({shares})")
    return lines


def gain_error(rows: list[Row]) -> float:
    """Root mean square distance of the gain from 1, over the films that have one; nan without any."""
    gains = [row["gain"] for row in rows if row["gain"] is not None]
    return float(np.sqrt(np.mean(np.square(np.array(gains) - 1)))) if gains else float("nan")


def residual(rows: list[Row]) -> float:
    """Median residual of the phase, rad, over the films that have one; nan without any."""
    found = [row["residual_rad"] for row in rows if row["residual_rad"] is not None]
    return float(np.median(found)) if found else float("nan")


def _seconds(rows: list[Row]) -> float:
    return float(np.mean([row["seconds"] for row in rows]))


def _figures(heading: str, key: tuple[str, str, float], rows: list[Row]) -> Row:
    effect, strength, distance = key
    name = f"{effect} {strength if effect != NOTHING else ''}".strip()
    figures = {"gain error": gain_error(rows), "residual": residual(rows), "s a film": _seconds(rows)}
    return {heading: f"{name:<29}{distance:>3g} m"} | counted_verdicts(rows) | figures


BENCH = Bench(rows, COLUMNS, summary, table=table)
