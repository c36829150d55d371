"""The forgers suite, with its table and plot.

Which attacks by a reader of this code are accepted, and what happens to honest films that a hand or an editor spoils.

Convention: a film is accepted, inconclusive or rejected by `verify` with the badge as claim and its identity; its
    figures as built are not known.
"""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.simulate.filming import film
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_rows import Where, chosen_names, rows_of_cases
from moireid_lab.bench.forgers.cases import ForgeryCase, Shoot, cases
from moireid_lab.bench.verdicts import COLOURS, VERDICTS, verdict_row

PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES = 240
CRF = 23
CAMERA = Camera(1280, 720, 1150.0)
HERE = Where()


def badge_of(axes: str) -> Badge:
    """The badge that is filmed."""
    return design_badge(Request("Bench", axes=axes), PAYLOAD)


def film_case(case: ForgeryCase, shoot: Shoot, video: Path) -> None:
    """Film one case."""
    filming = case.make(shoot)
    film(
        Scene(shoot.badge, Build.typical(shoot.seed), CAMERA),
        filming.motion,
        video,
        frames=round(shoot.length_s * filming.seconds_times * filming.fps),
        fps=filming.fps,
        show=filming.show,
        edit=filming.edit,
        seed=shoot.seed,
        crf=CRF,
    )


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case, judged."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = badge_of(case.axes)
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        film_case(case, Shoot(badge, (1000.0, 1400.0)[seed % 4 // 2], seed, frames), video)
        clock = time.perf_counter()
        report = verify(video, Claim(badge, badge.id))
        seconds = time.perf_counter() - clock
    return {"case": name, "genuine": case.genuine, "seed": seed, "seconds": seconds} | verdict_row(report)


def run(
    *,
    quick: bool,
    seed: int,
    clips: int | None,
    only: str | None = None,
    kept: Path | None,
    where: Where = HERE,
    progress: Callable[[int, int | None], None],
) -> dict[str, Any]:
    """All cases as one JSON object, or those whose name holds the regular expression `only`.

    Raises: SpecError where no case is left.
    """
    count = clips or (2 if quick else 100)
    chosen = chosen_names([case.name for case in cases()], only)
    numbers = range(seed, seed + count)
    rows = rows_of_cases(run_case, chosen, numbers, FRAMES, kept=kept, where=where, progress=progress)
    return {"suite": "forgers", "seed": seed, "rows": rows}


HEADINGS = {False: "forged", True: "genuine, as hands and editors spoil it"}


def forgers_table(result: dict[str, Any]) -> str:
    """Verdicts of each case, and why those that were not accepted were not."""
    lines = [f"{HEADINGS[False]:<58}{'accept':>8}{'open':>6}{'reject':>8}  s a film  most frequent reason"]
    for genuine in (False, True):
        if genuine:
            lines += ["", HEADINGS[True]]
        lines += [_line(name, rows) for name, rows in by_case(result, genuine).items()]
    return "\n".join(lines)


def _line(name: str, rows: list[dict[str, Any]]) -> str:
    counts = Counter(row["verdict"] for row in rows)
    why = Counter(code for row in rows for code in row["why"]).most_common(1)
    seconds = sum(row["seconds"] for row in rows) / len(rows)
    return (
        f"{name:<58}{counts['accept']:>8}{counts['inconclusive']:>6}{counts['reject']:>8}{seconds:>10.1f}  "
        f"{why[0][0] if why else ''}"
    )


def by_case(result: dict[str, Any], genuine: bool) -> dict[str, list[dict[str, Any]]]:
    """Rows of each case, in the order of the suite."""
    cases: dict[str, list[dict[str, Any]]] = {}
    for row in result["rows"]:
        if row["genuine"] == genuine:
            cases.setdefault(row["case"], []).append(row)
    return cases


def forgers_plot(result: dict[str, Any]) -> Any:
    """One bar a case: share of its films by verdict."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    groups = {genuine: by_case(result, genuine) for genuine in (False, True)}
    # A row for each case, and an empty one with the heading of each group, from the top.
    rows = [row for genuine, cases in groups.items() if cases for row in ((HEADINGS[genuine], []), *cases.items())]
    figure = Figure(figsize=(8, 0.18 * len(rows) + 1), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    begins = np.zeros(len(rows))
    for verdict, label in VERDICTS.items():
        shares = [sum(film["verdict"] == verdict for film in films) / max(len(films), 1) for _, films in rows]
        axes.barh(range(len(rows)), shares, left=begins, color=COLOURS[verdict], label=label)
        begins += shares
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=7)
    for mark, (_, films) in zip(axes.get_yticklabels(), rows, strict=True):
        mark.set_fontweight("normal" if films else "bold")
    axes.set(xlabel="share of films", xlim=(0, 1), ylim=(len(rows) - 0.5, -0.5))
    axes.tick_params(axis="y", length=0)
    axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    axes.spines[["top", "right", "left"]].set_visible(False)
    return figure
