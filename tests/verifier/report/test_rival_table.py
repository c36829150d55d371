"""The table of explanations, and the best rival's plot.  At each test: the wrong implementation it catches.

Documents are put together by hand, as `verify --json` prints them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kit.numeric_films import TYPICAL, filmed
from moireid.badge import Badge
from moireid.verifier.decision.comparison import CONTAINING, Explanation, cause_of
from moireid.verifier.decision.judge import judge
from moireid.verifier.explanations.honest import PhaseSeries
from moireid.verifier.explanations.rivals import RIVALS, Rival
from moireid.verifier.explanations.words import WORDS, does
from moireid.verifier.fringes.signals import measure
from moireid.verifier.identity.decode import Identity
from moireid.verifier.limits import CALIBRATION_CAP_LOG10
from moireid.verifier.report.rival_plot import best_fit, rival_plot, shaped_rival
from moireid.verifier.report.rival_table import odds_line, rivals_in, table_of
from moireid.verifier.session.result import Report


def entry(name: str, odds: float | None = 5.0, share: float | None = None, **parameters: float) -> dict[str, Any]:
    remains = (odds is not None and odds < -1) or (share or 0.0) > 0.02
    return {"name": name, "log10_odds": odds, "share": share, "fits": remains, "parameters": parameters}


LAW = {"name": "law", "log10_odds": 0.0, "share": None, "fits": True, "parameters": {"gain": 1.0, "lag_rad": 0.01}}


def document(*rivals: dict[str, Any], calibrated: float | None = 1.2) -> dict[str, Any]:
    return {"invariant": {"calibrated_log10": calibrated}, "explanations": [LAW, *rivals]}


def test_each_rival_that_is_compared_has_words() -> None:
    """Catches: a rival that is added and shown by its code, or one that is gone and keeps its words."""
    assert set(WORDS) == {"law", *(rival.name for rival in RIVALS), *CONTAINING}
    assert len({words.does for words in WORDS.values()}) == len(WORDS)
    assert {name for name, words in WORDS.items() if not words.remedy} == {"law"}


def test_odds_and_shares_are_shown_as_they_count() -> None:
    """Catches: the sign of the odds turned around; 99 of 100 shown as 0.99; a row that remains and is not marked."""
    table = table_of(document(entry("drift", -5.42, late_s=0.0), entry("late", 182.6, 0.99, late_s=-0.4)))
    assert table is not None
    law, drift, late = table.rows
    assert (law.law, law.power, law.share, law.remains) == (True, "", "", True)
    assert (drift.power, drift.share, drift.remains) == ("−5.4", "", True)
    assert (late.power, late.share, late.remains) == ("183", "99", True) and "0.4 s early" in late.does
    assert "2 other explanations" in table.compared and "gain" not in law.does


def test_what_the_film_shows_of_the_parameters_is_in_words() -> None:
    """Catches: seconds of a spell, or a gain, that only programs can read."""
    rows = table_of(
        document(entry("spell", 2.0, gain=0.0, start_s=1.0, end_s=2.5), entry("another_gain", 9.0, gain=0.67))
    )
    assert rows is not None
    assert rows.rows[1].does.endswith("from 1.0 to 2.5 s") and "0.67 times as far" in rows.rows[2].does


@pytest.mark.parametrize(
    ("calibrated", "words", "power"),
    [
        (1.2, "moderate support for the law", "1.2"),
        (-CALIBRATION_CAP_LOG10, "support for another explanation", f"{CALIBRATION_CAP_LOG10:.1f}"),
        (0.01, "no support either way", "0"),
    ],
)
def test_calibrated_odds_are_in_words_and_no_probability(calibrated: float, words: str, power: str) -> None:
    """Catches: odds against the law that read as odds for it; a number that people take for a probability."""
    table = table_of(document(entry("still"), calibrated=calibrated))
    assert table is not None and words in table.support and table.power == power
    assert table.capped == (abs(calibrated) == CALIBRATION_CAP_LOG10)
    line = odds_line(document(entry("still"), calibrated=calibrated))
    assert words in line and "no probability" in line.lower()


def test_a_report_without_a_table_has_none() -> None:
    """Catches: a page of an old report, of the published pipeline or of a film without a badge, that fails."""
    reports: tuple[dict[str, Any], ...] = ({}, {"explanations": []}, {"invariant": {"calibrated_log10": 1.0}})
    for said in reports:
        assert table_of(said) is None and odds_line(said) == "" and rivals_in(said) == []


def test_what_is_named_is_the_best_by_far_and_explains_the_film() -> None:
    """Catches: a delay named where a constant speed does as well; a cause that leaves most of the film unexplained."""
    fits = {"deviation_rad": 0.01, "limit_rad": 0.1}

    def named(*entries: dict[str, Any]) -> str | None:
        cause = cause_of(rivals_in(document(*entries)))
        return None if cause is None else cause.name

    drift, own = entry("drift", -5.4, **fits), entry("own_motion", -27.0)
    assert named(entry("still", -1.0), drift, entry("late", -4.3, **fits), own) == "drift"
    assert named(drift, entry("late", -5.6, **fits), own) == "own_motion"
    assert named(entry("drift", -5.4, deviation_rad=0.2, limit_rad=0.1), own) == "own_motion"
    assert named(entry("drift", 4.0, **fits), own) == "own_motion"
    assert named(entry("drift", -0.9, **fits), entry("late", 3.0)) is None


def series_of(measured: np.ndarray, law: np.ndarray) -> PhaseSeries:
    times = np.arange(len(law)) / 10
    zeros = np.zeros_like(law)
    place = np.column_stack([np.sin(3 * times), np.cos(times)])
    raw = PhaseSeries(
        times, measured, law, np.gradient(law, times), np.ones_like(law), zeros.astype(int), place, None, 0.01
    )
    return raw.weighted(raw.weight)


@pytest.mark.parametrize("rival", [rival for rival in RIVALS if rival.variants is not None], ids=lambda one: one.name)
def test_a_rival_s_own_fringes_are_fitted_whole(rival: Rival) -> None:
    """Catches: a plot of another rival's curve, or of one that is not fitted; a gain that is drawn over the design."""
    times = np.arange(80) / 10
    law = np.sin(times) + 0.3 * np.sin(2.3 * times)
    frame = series_of(law, law)
    assert frame.place_px is not None and rival.variants is not None
    made = {
        "still": np.zeros(80),
        "drift": 0.7 * times,
        "place": frame.place_px @ (0.5, -0.2),
        "another_gain": 0.4 * frame.law_rad,
        "late": None,
    }[rival.name]
    if made is None:
        made = next(columns[:, 0] for value, columns in rival.variants(frame) if value == 0.4)
    shown = series_of(made, law)
    one = Explanation(rival.name, -3.0, {"gain": 0.4} if rival.name == "another_gain" else {}, None, True)
    assert best_fit(one, shown) == pytest.approx(shown.measured_rad, abs=1e-9)


def report_of(badge: Badge) -> Report:
    track = filmed(badge, TYPICAL)
    measurement = measure(track, focal_px=1450.0)
    invariant = judge(measurement.gratings)
    who = Identity("not_claimed", ())
    film = {"path": "film.mp4", "sha256": "ab" * 32, "width": 1920, "height": 1080, "fps": 30.0}
    frames = {"read": 90, "tracked": 90}
    timing: dict[str, Any] = {"total_s": 1.0, "stages": {}}
    return Report("accept", invariant.reasons, invariant, who, film, frames, timing, (), track, measurement)


def test_the_plot_names_the_rival_that_is_nearest(ada: Badge) -> None:
    """Catches: a plot of the first rival of the list; a line without its name; a film without rivals."""
    report = report_of(ada)
    svg, best = rival_plot(report), shaped_rival(report)
    assert svg is not None and best is not None and f"if they {does(best.name, best.parameters)}" in svg
    assert "stroke-dasharray" in svg and "as seen" in svg

    def with_table(*rows: Explanation) -> Report:
        return replace(report, invariant=replace(report.invariant, explanations=rows))

    law = Explanation("law", 0.0, {}, None, True)
    drift, late = Explanation("drift", 1.0, {}, 0.06, True), Explanation("late", 1.0, {"late_s": 2.0}, 0.99, True)
    own = Explanation("own_motion", -9.0, {}, None, True)
    for rows, name in (((law, drift, late), "late"), ((law, replace(drift, log10_odds=-4.0), late, own), "drift")):
        found = shaped_rival(with_table(*rows))
        assert found is not None and found.name == name
    assert rival_plot(with_table()) is None and rival_plot(replace(report, measurement=None)) is None
    assert "if they come 2 s late" in (rival_plot(with_table(law, drift, late)) or "")
