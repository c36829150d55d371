"""What a prompt shows of an object is one line with what matters."""

from __future__ import annotations

from dataclasses import fields, replace

from kit.places import FILMS
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge, load_badge
from moireid.designer import Request, design_badge
from moireid.registry import Record
from moireid.simulate import Build, Camera, Scene
from moireid.verifier import Claim, verify

BADGE = design_badge(Request("Ada Lovelace"), bytes(range(8)))
BUILT = AsBuilt("0001020304050607", 0.08, 1e-4, 0.3, 0.01, 0.0, 1e-3, 1.012, 0.004, captures=2)


def test_a_badge_is_one_line() -> None:
    """Catches: the dataclass's own repr, 16 kB of cells; one that hides name, id or size."""
    cells = sum(len(grating.cells) for grating in BADGE.gratings)
    assert repr(BADGE) == f"Badge('Ada Lovelace', id='0001020304050607', 146 x 160 mm, {cells} cells)"
    assert repr(BADGE.gratings[0]) == (
        f"Grating(axis='x', pitch_mm={BADGE.gratings[0].pitch_mm:g}, spacing, {len(BADGE.gratings[0].cells)} cells)"
    )


def test_what_holds_a_badge_is_short_too() -> None:
    """Catches: a part with a long repr of its own, such as the cells of a grating."""
    assert len(repr(Claim(BADGE, BADGE.id))) < 600
    assert len(repr(Scene(BADGE, Build(), Camera()))) < 2500


def test_equal_means_equal_whatever_is_shown() -> None:
    """Catches: badges compared by what is shown of them, and a field that no longer counts."""
    assert {field.name for field in fields(Badge) if field.compare} == {field.name for field in fields(Badge)}
    other = replace(BADGE, range_m=(0.5, 1.0))
    assert repr(other) == repr(BADGE)
    assert other != BADGE


def test_measured_figures_are_one_line() -> None:
    """Catches: maps of places in the line; a beat of frequency 0, which has no period, as an error."""
    shown = "AsBuilt('0001020304050607', beat 12.50 mm, gain 1.012 ± 0.004, 2 captures)"
    assert repr(BUILT) == repr(replace(BUILT, place_maps=((0.1,) * 99,), place_map_sd=0.1)) == shown
    assert "no beat" in repr(replace(BUILT, beat_frequency_per_mm=0.0))


def test_a_record_is_one_line_with_its_state() -> None:
    """Catches: the badge's JSON in the line; a salt that a log would keep; a revoked badge that looks like others."""
    record = Record("00ff", "Ada", BADGE.to_json(), "2026-01-31T12:00:00Z", "key", salt="5a17")
    assert repr(record) == "Record('Ada', id='00ff', issued 2026-01-31)"
    later = replace(record, as_built="{}", as_built_at="2026-02-01T00:00:00Z", revoked_at="2026-03-01T00:00:00Z")
    assert repr(later) == "Record('Ada', id='00ff', issued 2026-01-31, measured 2026-02-01, revoked)"
    assert "expired" in repr(replace(record, expires="2026-02-01"))


def test_a_report_is_one_line_with_the_verdict() -> None:
    """Catches: a report that shows its arrays, or not what is wrong."""
    badge = load_badge(FILMS / "badge.json")
    genuine = repr(verify(FILMS / "genuine_1.0m.mp4", Claim(badge)))
    assert genuine.startswith(f"Report(accept, {badge.name!r}, badge in ")
    assert genuine.endswith(" frames)")
    forged = repr(verify(FILMS / "forged_reversed_1.0m.mp4", Claim(badge)))
    assert forged.startswith("Report(reject, ")
    assert ", gain" in forged
    assert len(forged) < 300
