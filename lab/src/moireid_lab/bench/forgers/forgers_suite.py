"""The forgers suite, with its table.

Which attacks by a reader of this code are accepted; true films on their trajectories are judged
next to them.

Convention: a film is accepted, inconclusive or rejected by `verify` with the badge as claim and its identity; its
    figures as built are not known.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, counted_verdicts, grouped, temporary_film
from moireid_lab.bench.forgers.cases import ForgeryCase, Shoot, cases
from moireid_lab.bench.verdicts import verdict_row

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES = 240
CRF = 23
CAMERA = Camera(1280, 720, 1150.0)


def badge_of(axes: str) -> Badge:
    """The badge that is filmed."""
    return design_badge(Order("Bench", lens="50lpi", axes=axes), PAYLOAD)


@contextmanager
def film_case(case: ForgeryCase, shoot: Shoot) -> Iterator[Path]:
    """The film of one case."""
    filming = case.make(shoot)
    with temporary_film(
        Scene(shoot.badge, Build.typical(shoot.seed), CAMERA),
        filming.motion,
        frames=round(shoot.length_s * filming.fps),
        fps=filming.fps,
        show=filming.show,
        seed=shoot.seed,
        crf=CRF,
    ) as video:
        yield video


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case, judged."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = badge_of(case.axes)
    with film_case(case, Shoot(badge, (1000.0, 1400.0)[seed % 4 // 2], seed, frames)) as video:
        clock = time.perf_counter()
        report = verify(video, Question(badge, badge.id))
        seconds = time.perf_counter() - clock
    return {"case": name, "genuine": case.genuine, "seed": seed, "seconds": seconds} | verdict_row(report)


def rows(wish: Wish) -> Iterator[Row]:
    """All cases, or those that are asked for.  Raises: SpecError where no case is left."""
    return wish.films(run_case, [case.name for case in cases()], FRAMES, wish.seeds(100, quick=2))


HEADINGS = {False: "forged", True: "genuine"}
COLUMNS = {HEADINGS[False]: "<58", HEADINGS[True]: "<58", "accept": ">8", "inconclusive": ">13", "reject": ">8"}
COLUMNS |= {"s a film": ">10.1f", "reasons": "<1"}


def table(rows: list[Row]) -> Iterator[Row]:
    """Verdicts of each case, and why those that were not accepted were not."""
    for genuine, heading in HEADINGS.items():
        for name, own in by_case(rows, genuine).items():
            seconds = sum(row["seconds"] for row in own) / len(own)
            yield {heading: name} | counted_verdicts(own, 1) | {"s a film": seconds}


def by_case(rows: list[Row], genuine: bool) -> dict[str, list[Row]]:
    """Rows of each case, in the order of the suite."""
    return grouped([row for row in rows if row["genuine"] == genuine], "case")


BENCH = Bench(rows, COLUMNS, table=table)
