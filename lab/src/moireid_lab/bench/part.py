"""A part of the scoreboard: its questions, the cases that answer them, and what makes and judges one case.

Convention: an answer counts judgements as (right, inconclusive, wrong).  A true film is right where it is accepted and
wrong where it is rejected, a forged one the other way round; one that is inconclusive is neither.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.files import write_text

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.designer import Order
    from moireid.simulate.motion import Motion
    from moireid.simulate.scene import Scene
    from moireid.verifier import Report

Row = dict[str, Any]
Answer = tuple[int, int, int]
RIGHT, INCONCLUSIVE, WRONG = (1, 0, 0), (0, 1, 0), (0, 0, 1)
OWN, OUTSIDE = "moireid simulate", "benchmarks/outside"


@dataclass(frozen=True)
class Asked:
    """What is asked of a part: films of each kind, None for the usual number; the folder of half-real clips."""

    clips: int | None = None
    data: Path | None = None


@dataclass(frozen=True)
class Part:
    """What answers some questions.

    questions: in words, by name; films_by: who made the films, of all questions or of each; cases: by name, in their
    order; judge: makes and judges one, in a folder that the cases of a run share, and gives a row: `kind`, `answers` by
    question, and figures; short: how many cases the short scoreboard has; sources: paths of files and folders on which
    rows depend besides the modules that are loaded; needs_data: whether cases are made of clips by others.
    """

    questions: Mapping[str, str]
    films_by: str | Mapping[str, str]
    cases: Callable[[Asked], Mapping[str, Any]]
    judge: Callable[[Any, Path], Row]
    short: int = 0
    sources: tuple[str, ...] = ()
    needs_data: bool = False


def answer_of(verdict: str, *, true: bool) -> Answer:
    """How a verdict counts."""
    return INCONCLUSIVE if verdict == "inconclusive" else RIGHT if true == (verdict == "accept") else WRONG


def identity_answer(report: Report, badge: Badge) -> Answer:
    """How an identity counts: read, not read, or another one read."""
    decoded = report.identity.decoded_id
    return RIGHT if decoded == badge.id else INCONCLUSIVE if decoded is None else WRONG


def why_not(report: Report) -> list[str]:
    """Codes of the findings that keep a film from being accepted."""
    return [reason.code for reason in report.reasons if reason.level in ("fail", "undecided")]


def film_row(kind: str, report: Report, *, true: bool, question: str = "", **figures: Any) -> Row:
    """The row of one film; question: "genuine" or "forged" where it is not said."""
    answers = {question or ("genuine" if true else "forged"): answer_of(report.verdict, true=true)}
    found = {"verdict": report.verdict, "why": why_not(report), "gain": report.invariant.gain_ratio}
    return {"kind": kind, "answers": answers} | found | figures


def interleaved(*lists: Mapping[str, Any]) -> dict[str, Any]:
    """Cases of several kinds, mixed evenly, so that a run that is stopped has its share of each."""
    shares = [(k / len(one), name, one[name]) for one in lists for k, name in enumerate(one)]
    return {name: case for _, name, case in sorted(shares, key=lambda share: share[0])}


def numbered(names: Sequence[str], count: int, start: int = 0) -> dict[str, tuple[str, int]]:
    """Each name with each of so many seeds: the first seed of all names first."""
    return {f"{name}|{seed}": (name, seed) for seed in range(start, start + count) for name in names}


@contextmanager
def temporary_film(scene: Scene, motion: Motion, **how: Any) -> Iterator[Path]:
    """A film that is gone afterwards; how: as `simulate.filming.film`."""
    from moireid.simulate.filming import film

    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        film(scene, motion, video, **how)
        yield video


def printed(order: Order, folder: Path) -> Badge:
    """A badge and its page in a folder, as `print-your-badge` makes them."""
    from moireid.fabrication.page.pdf import write_badge_pdf
    from moireid.issuing import plan_badge

    badge = plan_badge(replace(order, mount="none")).badge
    folder.mkdir(parents=True, exist_ok=True)
    write_badge_pdf(badge, folder / "badge.pdf")
    write_text(folder / "badge.json", badge.to_json())
    return badge
