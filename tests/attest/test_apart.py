"""The process that judges has no key, and its answers are checked.  Each test names the fault that it catches."""

from __future__ import annotations

import pickle
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from kit.places import FILMS
from moireid.attest.credentials import talk_with
from moireid.badge import load_badge
from moireid.errors import MediaError, MoireIdError
from moireid.reading.film_reports import judged_film
from moireid.verifier import Question

WORK = "kit.sandbox_work:act"


QUESTION = Question(load_badge(FILMS / "badge.json"))


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
