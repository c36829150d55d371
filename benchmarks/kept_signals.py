"""The kept signals of the golden corpus, judged by their names: run `moireid lab bench kept`.

`golden.py` says how films and signals are made: by `moireid simulate`, the outside tracer, and half real.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import Any

import golden

from moireid.verifier.reasons import worst
from moireid_lab.bench.part import OUTSIDE, OWN, Asked, Part, Row, answer_of

#: Each beginning of a corpus film's name, with the question that its films answer.
QUESTIONS = {
    "forged": "Is a forged film rejected? 13 kinds on four motions",
    "half-real": "Is a true badge accepted that is drawn into films of four real webcams?",
    "half-real forged": "Is a forged one rejected there? Frozen, or half the gain",
    "built": "Is a board accepted whose page or sheet is off, or under air? Not enrolled",
    "lens": "Is a true film through a lens of 0.5 to 8 times the long side accepted?",
    "natural": "Is a true film of 4 s of natural motion accepted?",
    "effect": "Is a true film of 4 s accepted after what phones, calls and editors do to it?",
    "format": "Is a true film of 4 s accepted, of each format?",
    "data": "Are the films of tests/data judged as what they are?",
}
FILMS_BY = dict.fromkeys(QUESTIONS, OUTSIDE) | dict.fromkeys(("forged", "effect"), OWN)
FILMS_BY |= dict.fromkeys(("half-real", "half-real forged"), f"{OUTSIDE}, in real films") | {"data": "another tracer"}
STARTS = {"forged-real": "half-real forged", "real": "half-real", "build": "built"}


def question_of(case: str) -> str:
    """The question that a film answers."""
    start = case.split("-")[0] if not case.startswith("forged-real") else "forged-real"
    return STARTS.get(start, start)


def cases(asked: Asked) -> dict[str, list[Path]]:
    """The files of each question."""
    # Four true films next to the forged ones, for headlines, belong to no question.
    some = (path for path in golden.SIGNALS.glob("*.signals") if not path.stem.startswith("forged-true"))
    files = sorted(some, key=lambda path: (question_of(path.stem), path.stem))
    return {question: list(own) for question, own in groupby(files, key=lambda path: question_of(path.stem))}


def judged(files: list[Path], folder: Path) -> Row:
    """All films of a question."""
    counts, why = [0, 0, 0], list[str]()
    for path in files:
        _, reasons = golden.KeptFilm.from_bytes(path.read_bytes()).judged()
        answer: Any = answer_of(worst(list(reasons)), true=not golden.is_forged(path.stem))
        counts = [count + one for count, one in zip(counts, answer, strict=True)]
        why += [one.code for one in reasons if one.level in ("fail", "undecided") and answer != (1, 0, 0)]
    name = question_of(files[0].stem)
    return {"kind": name, "answers": {name: counts}, "why": why}


PART = Part(QUESTIONS, FILMS_BY, cases, judged, 99, ("tests/data/golden",))
