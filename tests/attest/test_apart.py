"""The process that judges has no key, and its answers are checked.  Each test names the fault that it catches."""

from __future__ import annotations

import pickle
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from kit.places import FILMS
from moireid import errors
from moireid.attest.credentials import talk_with
from moireid.badge import load_badge
from moireid.errors import CodeError, MediaError, MoireIdError
from moireid.provenance import Exclusion
from moireid.reading.film_reader import fault_of, film_reader
from moireid.reading.film_reports import judged_film
from moireid.sandbox.process import ProcessEnd
from moireid.sandbox.seal import MEANS
from moireid.verifier import Question

WORK = "kit.sandbox_work:act"


QUESTION = Question(load_badge(FILMS / "badge.json"))


@pytest.mark.slow
def test_the_report_is_the_one_that_is_judged_here(film: Path, judged: dict[str, Any]) -> None:
    """Catches: another verdict by another way; a report's page that is forgotten; progress that is not shown."""
    seen: list[tuple[int, int | None]] = []
    question = replace(QUESTION, barred=Exclusion("revoked", "2026-05-03T08:00:00Z", "lost"))
    with film_reader([film]) as reader:
        there = judged_film(film, question, reader, lambda *counts: seen.append(counts), pictures=True)
    found = there.result
    assert found["verdict"] == "reject" and found["reasons"][-1]["code"] == "revoked"
    assert found["invariant"] == judged["invariant"]
    assert found["sealed"] == (list(MEANS) if sys.platform == "linux" else [])
    assert {"law.svg", "badge.png"} <= set(there.pictures.files) and seen and seen[0][1] in (70, None)
    assert there.pictures.signals.startswith("frame,time_s") and there.pictures.signals.count("\n") > 60


@pytest.mark.parametrize(
    ("asked", "error", "words"),
    [
        ("crash", MediaError, "SIGSEGV"),
        ("leave", MediaError, "exit code 7"),
        ("fail", MediaError, "LookupError: nothing there"),
        ("refuse", MediaError, "no film"),
    ],
)
def test_a_process_that_fails_is_reported_in_a_sentence(asked: str, error: type[MoireIdError], words: str) -> None:
    """Catches: a traceback, or a wait without an end, where a film breaks its reader."""
    with pytest.raises(error, match=words) as caught:
        talk_with(WORK, (asked,), Path("film.mp4"), lambda message: None)
    assert "\n" not in str(caught.value)


def test_an_error_of_the_work_keeps_its_kind() -> None:
    """Catches: a badge that this version cannot read reported as a damaged film; a kind that a process makes up."""
    kinds = {
        "CodeError": CodeError,
        "MissingExtraError": errors.MissingExtraError,
        "SystemExit": MediaError,
        "__doc__": MediaError,
    }
    for kind, wanted in kinds.items():
        assert type(fault_of(ProcessEnd(kind, "why", ours=True), "film.mp4")) is wanted


def test_a_report_of_another_film_is_not_taken(film: Path, tmp_path: Path, judged: dict[str, Any]) -> None:
    """Catches: a film that is swapped while it is judged, and a process that reports what it likes."""
    here = Path(shutil.copy(film, tmp_path / "film.mp4"))
    for report in (judged | {"input": judged["input"] | {"sha256": "0" * 64}}, judged | {"input": None}, {}, [1]):

        class Hostile:
            sealed = ()

            def read(self, order: Any, progress: Any, answer: Any = None, result: Any = report) -> dict[str, Any]:
                # What the process is given holds no key: neither its file nor its content.
                assert not re.search(rb"PRIVATE|\.pem|Ed25519|Elliptic", pickle.dumps(order))
                return {"result": result}

        with pytest.raises(MediaError, match=r"changed while it was judged|answers what no film shows"):
            judged_film(here, QUESTION, Hostile(), lambda done, of: None)
