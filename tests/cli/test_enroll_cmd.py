"""enroll with captures: what is refused, what is kept.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import json
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from kit.registries import run
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.reading.film_reader import Reader
from moireid.registry import Record, Registry
from moireid.verifier.session import capture

WHY = "the sheet was put on again"


@pytest.fixture
def enroll(tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch):
    """Enroll Ada's badge with a capture that shows these figures."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    (tmp_path / "badge.json").write_text(ada.to_json(), encoding="utf-8")
    to = ("--registry", f"sqlite:///{tmp_path / 'people.sqlite3'}")

    def enrolled(figures: AsBuilt, *words: str, code: int = 0):
        monkeypatch.setattr(capture, "capture_as_built", lambda *_, **__: figures)
        # In this process, so that it measures so, too.
        monkeypatch.setattr("moireid.cli.enroll_cmd.sealed_reader", lambda *_, **__: nullcontext(Reader()))
        return run("enroll", tmp_path / "badge.json", "--capture", "film.mp4", *to, *words, code=code)

    enrolled.to = to  # type: ignore[attr-defined]
    return enrolled


@pytest.fixture
def true(ada: Badge) -> AsBuilt:
    return AsBuilt(str(ada.id), -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.01)


def shown(enroll) -> dict:
    return json.loads(run("registry", "show", "Ada Lovelace", "--json", *enroll.to).stdout)


@pytest.mark.claim("Figures of enrolment are replaced only with a reason")
def test_a_poisoned_capture_is_refused_and_shown_side_by_side(enroll, true):
    """Catches: figures that are replaced without a note, so that the holder's own badge is rejected as a copy."""
    poison = replace(true, gain_ratio=0.63, offset_rad=true.offset_rad + 2)
    enroll(true)
    refused = enroll(poison, code=2)
    assert refused.stdout == "" and "0.995 ± 0.01" in refused.stderr and "0.63 ± 0.01" in refused.stderr
    assert "allowed ✗" in refused.stderr and "differ from the known ones (offset, gain)" in refused.stderr
    assert shown(enroll)["as_built"]["gain_ratio"] == 0.995
    # Where nothing is known yet, the badge is not even enrolled.
    other = replace(true, gain_ratio=0.51)
    assert "no lens sheet as sold" in enroll(other, "--registry", enroll.to[1] + ".new", code=2).stderr
    assert run("registry", "list", "--registry", enroll.to[1] + ".new").stdout == ""


def test_a_reason_replaces_them_and_those_of_before_stay(enroll, true):
    """Catches: a reason that is not recorded; earlier figures that are lost; an audit that the change makes unsound."""
    enroll(true)
    for words in (("--replace",), ("--reason", WHY)):
        assert "go together" in enroll(true, *words, code=2).stderr
    assert "plain words" in enroll(true, "--replace", "--reason", " ", code=2).stderr
    other = replace(true, offset_rad=true.offset_rad + 2)
    assert "1 earlier set of figures stay on record" in enroll(other, "--replace", "--reason", WHY).stdout
    record = shown(enroll)
    assert (record["as_built"]["offset_rad"], record["as_built_reason"]) == (other.offset_rad, WHY)
    assert [one["as_built"]["offset_rad"] for one in record["as_built_earlier"]] == [true.offset_rad]
    text = run("registry", "show", "Ada Lovelace", *enroll.to).stdout
    assert WHY in text and "which count too" in text
    assert "as_built_replaced" in run("registry", "log", *enroll.to).stdout
    assert json.loads(run("registry", "audit", "--json", *enroll.to).stdout)["sound"]


def test_a_second_true_capture_needs_nothing(enroll, true):
    """Catches: honest captures refused for their scatter; figures in use that wander with each capture."""
    enroll(true)
    again = replace(true, offset_rad=3.05, gain_ratio=1.002)
    assert "which stay in use" in enroll(again).stdout
    said = json.loads(enroll(again, "--json").stdout)
    assert (said["capture_outcome"], said["capture"]["offset_rad"], said["as_built"]["offset_rad"]) == (
        "same",
        3.05,
        3.0,
    )
    assert json.loads(enroll(true, "--json").stdout)["as_built"] == json.loads(true.to_json())
    actions = [one["action"] for one in json.loads(run("registry", "log", "--json", *enroll.to).stdout)["entries"]]
    assert actions.count("as_built") == 1 and len(actions) == 3


def test_figures_that_come_in_while_a_capture_is_entered_are_compared_too(enroll, true, monkeypatch):
    """Catches: figures taken for a badge's first although others came in since they were compared."""
    poison = replace(true, gain_ratio=1.2, offset_rad=true.offset_rad + 2)
    enter = Registry.enroll

    def entered_second(registry: Registry, *given: object, **named: object) -> Record:
        record = enter(registry, *given, **named)
        return record if record.as_built else registry.store_as_built(record.id, true.to_json())

    monkeypatch.setattr(Registry, "enroll", entered_second)
    assert "differ from the known ones (offset, gain)" in enroll(poison, code=2).stderr
    record = shown(enroll)
    assert (record["as_built"]["gain_ratio"], record["as_built_earlier"]) == (0.995, [])
