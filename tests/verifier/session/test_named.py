"""Who is named for a film.  Each test names the fault that it catches."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from moireid.verifier.decision.judge import Invariant
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason
from moireid.verifier.session.identify import judge, of_enrolled


def found_among(ids: list[str], law: str = "accept", *reasons: Reason, **identity: object) -> dict[str, Any]:
    invariant = Invariant(law, ())  # type: ignore[arg-type]
    report = SimpleNamespace(reasons=reasons, invariant=invariant, identity=Identity("not_claimed", (), **identity))
    found = replace(judge(report), report=None)  # type: ignore[arg-type]
    return of_enrolled(found.to_json(), ids.__contains__)


def test_a_decoded_id_under_another_s_beats_identifies_no_one(rng):
    """Catches: beats that only a claim is held against."""
    badge_id = rng.bytes(8).hex()
    outcome = found_among([badge_id], decoded_id=badge_id, beats_agree=False)
    assert (outcome["finding"], outcome["found_id"]) == ("nobody", None)
    assert outcome["reasons"][-1]["code"] == "beats"
    assert found_among([badge_id], decoded_id=badge_id)["finding"] == "found"


@pytest.mark.parametrize(
    ("law", "doubts", "enrolled", "finding"),
    [
        ("reject", (), True, "nobody"),
        ("inconclusive", (), True, "inconclusive"),
        ("accept", ("damaged",), True, "inconclusive"),
        ("accept", ("cover",), True, "inconclusive"),
        ("accept", (), False, "nobody"),
        ("inconclusive", (), False, "nobody"),
    ],
)
def test_a_name_needs_the_law_a_whole_film_and_a_record(law, doubts, enrolled, finding):
    """Catches: somebody named for a forged film, or one that was not judged whole; a stranger taken for somebody."""
    notes = [Reason(code, "undecided", None, None, "", "") for code in doubts]
    people = ["0102030405060708"] if enrolled else []
    outcome = found_among(people, law, *notes, decoded_id="0102030405060708")
    assert outcome["finding"] == finding
    assert enrolled or (outcome["found_id"], outcome["reasons"][-1]["code"]) == (None, "enrolled")
