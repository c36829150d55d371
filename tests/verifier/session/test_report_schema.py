"""The JSON report against its schema, for every way a verify can end.  Each test states what it would catch."""

from __future__ import annotations

import copy
from typing import Any

import jsonschema
import numpy as np
import pytest

from kit.coded_films import first_frames, written
from kit.places import FILMS
from kit.report_faults import SCHEMA, faults, named_only
from moireid.provenance import Revocation
from moireid.verifier import KnownCamera, Question, verify
from moireid.verifier.session.result import REPORT_FORMAT
from moireid_lab.baseline.pipeline import verify_published


@pytest.fixture(scope="module")
def reports(tmp_path_factory) -> dict[str, dict[str, Any]]:
    """One report for each kind of verdict, from short films by an outside simulator."""
    from moireid.badge import load_badge

    films = tmp_path_factory.mktemp("films")
    board = load_badge(FILMS / "badge.json")
    grey = np.full((120, 160), 90, np.uint8)
    nothing = written(films / "nothing.mp4", [grey] * 3, "libx264", "yuv420p")
    genuine, reversed_ = (
        first_frames(FILMS / name, films / name, 70) for name in ("genuine_1.0m.mp4", "forged_reversed_1.0m.mp4")
    )
    return {
        "accept": verify(genuine, Question(board)).to_json(),
        "reject": verify(reversed_, Question(board)).to_json(),
        "unreadable": verify(genuine, Question(board, "00" * 8, camera=KnownCamera(1450.0))).to_json(),
        "revoked": verify(genuine, Question(board, barred=Revocation("2026-05-03T08:00:00Z", "lost"))).to_json(),
        "no face": verify(reversed_, Question(board, overlap=True)).to_json(),
        "no badge": verify(nothing, Question(board, "00" * 8)).to_json(),
        "published": verify_published(genuine, Question(board)).to_json(),
        "published, no badge": verify_published(nothing, Question(board, "00" * 8)).to_json(),
    }


@pytest.mark.slow
def test_the_schema_is_one():
    """Catches: a keyword misspelt so that it holds nothing."""
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert SCHEMA["properties"]["format"]["const"] == REPORT_FORMAT == 2 and SCHEMA["$id"].endswith(":2")


@pytest.mark.slow
def test_every_end_of_a_verify_is_as_the_schema_says(reports):
    """Catches: a figure that is missing where nothing was measured; a key that was added and never described."""
    ends = {name: report["verdict"] for name, report in reports.items()}
    assert set(ends.values()) == {"accept", "reject", "inconclusive"}
    assert ends["accept"] == "accept" and ends["reject"] == "reject" and ends["no badge"] == "inconclusive"
    closed = named_only(SCHEMA)
    for name, report in reports.items():
        assert faults(report) == [], name
        assert faults(report, closed) == [], name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("verdict",), "maybe"),
        (("explanations", 0, "fits"), None),
        (("explanations", 1, "share"), 1.5),
        (("frames", "read"), 1.5),
        (("input", "sha256"), "ab"),
        (("reasons", 0, "level"), "fail"),
        (("invariant", "verdict"), "reject"),
        (("reasons",), []),
        (("camera", "focal_px"), 0),
    ],
)
def test_what_is_wrong_is_refused(reports, place, value):
    """Catches: a schema that lets everything through; an acceptance beside a failed test."""
    document = copy.deepcopy(reports["accept"])
    inner = document
    for key in place[:-1]:
        inner = inner[key]
    assert inner[place[-1]] != value
    inner[place[-1]] = value
    assert faults(document)
