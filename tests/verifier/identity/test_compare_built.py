"""As-built figures: merging, reading back, and comparing a film with them."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from moireid.asbuilt import AsBuilt, as_built_from_json, merge
from moireid.errors import SpecError
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.identity.compare_built import _worst_stretch, compare_built
from moireid.verifier.measuring import PAPER_GROWTH_SHARE, SHEET_GROWTH_PER_K, WEATHER_K
from moireid_lab.bench.identity.clips import Clip, read_clip

ONE = AsBuilt("7097c67b0fafc59b", -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.995, 0.01)


def test_captures_merge_by_their_information_and_around_the_circle():
    """Catches: offsets of 3.1 and -3.1 averaged to 0; equal weights; error bars that shrink where captures disagree."""
    other = replace(ONE, offset_rad=-3.1, offset_sd=0.04, gain_ratio=1.095, gain_sd=0.1)
    both = merge([replace(ONE, offset_rad=3.1), other])
    assert abs(abs(both.offset_rad) - math.pi) < 1e-6
    assert both.gain_ratio == pytest.approx((0.995 * 100 + 1.095) / 101, abs=1e-4)
    assert both.captures == 2
    apart = merge([ONE, replace(ONE, offset_rad=2.0)])
    assert apart.offset_sd > 0.3
    with pytest.raises(SpecError):
        merge([ONE, replace(ONE, badge_id="00")])


def test_each_figure_tells_a_copy_alone(ada):
    """Catches: a figure that is not compared, or compared without regard to turns of the circle."""
    assert compare_built(ONE, ONE, ada).built == "agrees"
    assert compare_built(replace(ONE, offset_rad=3.0 - 2 * math.pi + 0.02), ONE, ada).built == "agrees"
    assert compare_built(replace(ONE, offset_rad=2.0), ONE, ada).built == "differs"
    assert compare_built(replace(ONE, twist_rad_per_mm=0.06), ONE, ada).built == "differs"
    assert compare_built(replace(ONE, beat_frequency_per_mm=-0.0465), ONE, ada).built == "differs"
    assert compare_built(replace(ONE, offset_rad=3.0 - 0.35), ONE, ada).built == "not_known"


def test_maps_of_places_are_compared_where_both_are_known(ada):
    """Catches: a map that is never compared; one compared with nothing; an error bar that is left out."""
    wave = np.cos(np.arange(12))
    known = replace(ONE, place_maps=(tuple(0.2 * wave),), place_map_sd=0.01)
    again = replace(known, place_maps=(tuple(0.2 * wave + 0.02 * np.sin(np.arange(12))),))
    other = replace(known, place_maps=(tuple(-0.2 * wave),))
    assert compare_built(again, known, ada).built == compare_built(other, ONE, ada).built == "agrees"
    found = compare_built(other, known, ada)
    (reason,) = (one for one in found.reasons if one.code == "as_built_map")
    assert found.built == "differs" and reason.measured == pytest.approx(0.4 * np.sqrt(np.mean(wave**2)))
    # A film that is made noisy neither agrees with another map nor is rejected for its own.
    assert compare_built(replace(other, place_map_sd=0.2), known, ada).built == "not_known"
    assert compare_built(replace(again, place_map_sd=0.2), known, ada).built == "agrees"


@pytest.mark.parametrize(
    "changed",
    [{"place_maps": []}, {"place_map_sd": None}, {"place_map_sd": 0}, {"place_map_sd": 1e6}, {"place_maps": [[1e9]]}],
)
def test_maps_that_no_film_shows_are_refused(changed):
    """Catches: an error bar that makes any map agree; a map without one; values that turn fringes many times."""
    good = json.loads(replace(ONE, place_maps=((0.1, 0.2),), place_map_sd=0.01).to_json())
    assert as_built_from_json(json.dumps(good)).place_maps == ((0.1, 0.2),)
    with pytest.raises(SpecError, match="as-built figures"):
        as_built_from_json(json.dumps(good | changed))


def test_a_badge_that_weather_grew_is_still_the_original(ada):
    """Catches: a limit without room for humidity; and that room given where the beat shows no drift."""
    drift = 0.8 * PAPER_GROWTH_SHARE[0] / ada.lens.pitch_mm
    moved = replace(ONE, beat_frequency_per_mm=ONE.beat_frequency_per_mm + drift, offset_rad=ONE.offset_rad - 0.6)
    assert compare_built(moved, ONE, ada).built == "agrees"
    assert compare_built(replace(moved, beat_frequency_per_mm=ONE.beat_frequency_per_mm), ONE, ada).built == "differs"


def test_warmth_moisture_and_both_together(ada):
    """Catches: a warm badge called a copy; warmth and moisture that cancel; room for both given to an original; the
    growth across the fibre given along it.
    """
    axis_y = replace(ada, gratings=tuple(replace(grating, axis="y") for grating in ada.gratings))
    warmth, pitch = SHEET_GROWTH_PER_K * WEATHER_K, ada.lens.pitch_mm

    def built(share, badge=ada):
        return compare_built(
            replace(ONE, beat_frequency_per_mm=ONE.beat_frequency_per_mm + share / pitch), ONE, badge
        ).built

    wet, wet_along = PAPER_GROWTH_SHARE
    assert built(warmth) == built(-warmth) == built(wet) == built(-wet) == "agrees"
    assert built(0.97 * (warmth + wet)) == "not_known"
    assert built(1.1 * (warmth + wet)) == "differs"
    assert built(1.1 * (warmth + wet_along), axis_y) == "differs" != built(1.1 * (warmth + wet_along))


def test_the_worst_stretch_is_told_with_the_error_of_the_gain():
    """Catches: a stretch seen from aside taken for a moved sheet because the gain is vague; a moved one overlooked."""
    times = np.arange(300) / 30.0
    law = np.where(times < 5, 0.2, 1.8) + 0.3 * np.sin(2 * np.pi * 0.5 * times)
    none = np.zeros(300)
    signal = GratingSignal(
        law, law, np.full(300, 0.01), 0.01, np.array([0.01]), times, stretch=(times >= 5).astype(np.int64)
    )
    assert _worst_stretch(none, law, signal, 0.01)[0] == 0.0
    moved = np.where(times < 5, -0.15, 0.15)
    apart, sd = _worst_stretch(moved, law, signal, 0.01)
    assert apart == pytest.approx(0.15, abs=0.01)
    assert apart > 2 * sd
    assert apart < 2 * _worst_stretch(moved, law, signal, 0.1)[1]
    assert _worst_stretch(moved, law, replace(signal, stretch=np.zeros(300, np.int64)), 0.01)[0] == 0.0


@pytest.mark.parametrize(
    ("found", "known"),
    [(ONE, True), (replace(ONE, offset_rad=2.8), False), (replace(ONE, gain_ratio=1.05), False)],
    ids=["as enrolled", "offset off", "gain off"],
)
def test_the_phase_constant_is_known_only_where_gain_and_offset_agree_closely(ada, found, known):
    """Catches: the wide limits of an original used where a delay must be excluded."""
    outcome = compare_built(found, ONE, ada)
    assert outcome.built == "agrees"
    assert (outcome.constant_room_rad is not None) == known


@pytest.mark.slow
def test_films_of_one_badge_agree_and_of_a_copy_do_not(ada):
    """The whole way, on three small films: enrolled, filmed again in other motion, assembled anew."""
    payload = bytes.fromhex("0123456789abcdef")
    rows = [
        read_clip(Clip(payload, 1000.0, 5, motion, assembly, frames=120))
        for motion, assembly in ((1, None), (2, None), (3, 77))
    ]
    assert [row["read"] for row in rows] == [True] * 3
    enrolled, again, copy = (as_built_from_json(row["as_built"]) for row in rows)
    assert max(abs(row["beat_error"]) for row in rows) < 0.005
    assert compare_built(again, enrolled, ada).built == "agrees"
    assert compare_built(copy, enrolled, ada).built == "differs"
