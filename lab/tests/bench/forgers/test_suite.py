"""A few cases filmed and judged.  Each test states what it would catch."""

from __future__ import annotations

import json

import pytest

from moireid_lab.bench.forgers.forgers_suite import judged


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "verdict", "why"),
    [
        ("8 photographs, cross-faded", "inconclusive", "spacing"),
        ("one photograph in turns, plain cuts", "inconclusive", "motion"),
        ("frozen for 2 s", "reject", "residual"),
        ("frozen for 50 % of the frames, markers shifted", "inconclusive", "motion"),
        ("plain", "accept", None),
    ],
)
def test_an_attack_is_not_accepted_and_a_true_film_is(name, verdict, why, tmp_path):
    """Catches: an attack filmed as the truth, a true film that shows no badge, a row that JSON cannot hold."""
    row = judged((name, 1), tmp_path)
    assert row["verdict"] == verdict and (why in row["why"] if why else not row["why"])
    assert json.dumps(row, allow_nan=False)
    assert row["kind"] == name and list(row["answers"]) == ["genuine" if verdict == "accept" else "forged"]
