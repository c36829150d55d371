"""The forgers suite, with its table and plot.

Which attacks by a reader of this code are accepted, and what happens to honest films that a hand or an editor spoils.

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
from moireid.designer import Request, design_badge
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Wish, counted_verdicts, film_cases, grouped, temporary_film, text_table
from moireid_lab.bench.bench_plots import figure_of, verdict_bars
from moireid_lab.bench.forgers.cases import ForgeryCase, Shoot, cases
from moireid_lab.bench.verdicts import verdict_row

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES = 240
CRF = 23
CAMERA = Camera(1280, 720, 1150.0)


def badge_of(axes: str) -> Badge:
    """The badge that is filmed."""
    return design_badge(Request("Bench", axes=axes), PAYLOAD)


@contextmanager
def film_case(case: ForgeryCase, shoot: Shoot) -> Iterator[Path]:
    """The film of one case."""
    filming = case.make(shoot)
    with temporary_film(
        Scene(shoot.badge, Build.typical(shoot.seed), CAMERA),
        filming.motion,
        frames=round(shoot.length_s * filming.seconds_times * filming.fps),
        fps=filming.fps,
        show=filming.show,
        edit=filming.edit,
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
        report = verify(video, Claim(badge, badge.id))
        seconds = time.perf_counter() - clock
    return {"case": name, "genuine": case.genuine, "seed": seed, "seconds": seconds} | verdict_row(report)


def run(wish: Wish) -> dict[str, Any]:
    """All cases as one JSON object, or those that are asked for.  Raises: SpecError where no case is left."""
    names, seeds = [case.name for case in cases()], wish.seeds(100, quick=2)
    return {"suite": "forgers", "seed": wish.seed, "rows": film_cases(run_case, names, FRAMES, seeds, wish)}


HEADINGS = {False: "forged", True: "genuine, as hands and editors spoil it"}
COLUMNS = {HEADINGS[False]: "<58", HEADINGS[True]: "<58", "accept": ">8", "inconclusive": ">13", "reject": ">8"}
COLUMNS |= {"s a film": ">10.1f", "reasons": "<1"}


def forgers_table(result: dict[str, Any]) -> str:
    """Verdicts of each case, and why those that were not accepted were not."""
    rows = [
        {HEADINGS[genuine]: name}
        | counted_verdicts(rows, 1)
        | {"s a film": sum(r["seconds"] for r in rows) / len(rows)}
        for genuine in HEADINGS
        for name, rows in by_case(result, genuine).items()
    ]
    return text_table(rows, COLUMNS)


def by_case(result: dict[str, Any], genuine: bool) -> dict[str, list[dict[str, Any]]]:
    """Rows of each case, in the order of the suite."""
    return grouped([row for row in result["rows"] if row["genuine"] == genuine], "case")


def forgers_plot(result: dict[str, Any]) -> Any:
    """One bar a case: share of its films by verdict."""
    groups = {genuine: by_case(result, genuine) for genuine in (False, True)}
    # A row for each case, and an empty one with the heading of each group, from the top.
    rows = [row for genuine, cases in groups.items() if cases for row in ((HEADINGS[genuine], []), *cases.items())]
    figure = figure_of(8, 0.18 * len(rows) + 1)
    axes = figure.add_subplot()
    verdict_bars(axes, [films for _, films in rows])
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=7)
    for mark, (_, films) in zip(axes.get_yticklabels(), rows, strict=True):
        mark.set_fontweight("normal" if films else "bold")
    axes.set(xlabel="share of films", xlim=(0, 1), ylim=(len(rows) - 0.5, -0.5))
    axes.tick_params(axis="y", length=0)
    axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    axes.spines[["top", "right", "left"]].set_visible(False)
    return figure
