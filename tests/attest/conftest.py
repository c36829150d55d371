"""A true report, and signed verdicts of it."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kit.coded_films import first_frames
from kit.places import FILMS
from moireid.attest.envelope import signed_envelope
from moireid.attest.signing_keys import SigningKey
from moireid.attest.statement import attested, statement
from moireid.badge import load_badge
from moireid.verifier import Question, verify


@pytest.fixture(scope="session")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The beginning of a true film."""
    return first_frames(FILMS / "genuine_1.0m.mp4", tmp_path_factory.mktemp("film") / "film.mp4", 70)


@pytest.fixture(scope="session")
def judged(film: Path) -> dict[str, Any]:
    """Its report."""
    return verify(film, Question(load_badge(FILMS / "badge.json"))).to_json()


Sign = Callable[..., str]


@pytest.fixture
def sign(judged: dict[str, Any]) -> Sign:
    """Sign the report, or a changed one, with a key."""

    def signed(key: SigningKey, **changes: Any) -> str:
        registry = {"fingerprint": "ab" * 16, "head": "2:" + "cd" * 32, "expires": None}
        report = attested(copy.deepcopy(judged) | {"registry": registry} | changes, key)
        return signed_envelope(statement(report, "film.mp4"), key)

    return signed
