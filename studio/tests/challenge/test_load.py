"""Advice by what was measured: the processor, or the way of the pictures.  Each test names what it would catch."""

from __future__ import annotations

from typing import Any

import pytest

from kit.live_verdicts import headline, said
from moireid_studio.challenge.live_headline import SLOWLY
from moireid_studio.challenge.load import LEAST_PICTURES, Load, load_advice


class Clock:
    """A clock that is set by hand, s."""

    def __init__(self) -> None:
        self.now_s = 5.0

    def __call__(self) -> float:
        return self.now_s


def measured(judging_s: float, waiting_s: float, pictures: int = 48) -> dict[str, float] | None:
    """The load of a session in which each picture took so long to be judged, and then to come."""
    clock = Clock()
    load = Load(clock)
    for _ in range(pictures):
        with load.judging(pictures=0):
            clock.now_s += judging_s / 4
        with load.judging():
            clock.now_s += 3 * judging_s / 4
        clock.now_s += waiting_s
    return load.to_json()


@pytest.mark.parametrize(
    ("judging_s", "waiting_s", "words", "never"),
    [
        (0.070, 0.000, "processor of the machine that judges is busy", "connection"),
        (0.060, 0.030, "processor of the machine that judges is busy", "connection"),
        (0.012, 0.100, "camera or connection are slow", "processor"),
        (0.012, 0.020, None, None),
        (0.030, 0.003, None, None),
    ],
)
def test_the_advice_is_of_what_was_slow(
    judging_s: float, waiting_s: float, words: str | None, never: str | None
) -> None:
    """Catches: "a faster connection" on loopback, where the processor is busy; a busy machine blamed for a slow camera;
    advice where nothing was slow.
    """
    load = measured(judging_s, waiting_s)
    assert load is not None and load["judging_ms"] == pytest.approx(1000 * judging_s, abs=0.1)
    assert load["pictures_per_s"] == pytest.approx(1 / (judging_s + waiting_s), rel=0.05)
    advice = load_advice(load)
    if words is None:
        assert advice is None
    else:
        assert advice is not None and words in advice and str(never) not in advice


def test_too_few_pictures_give_no_mean() -> None:
    """Catches: the first picture's slow start as the machine's speed; a division by nothing."""
    assert Load().to_json() is None and measured(0.5, 0.0, LEAST_PICTURES - 1) is None


@pytest.mark.parametrize(
    "load", [None, "fast", [], {}, {"judging_ms": "70"}, {"judging_ms": float("nan"), "pictures_per_s": None}]
)
def test_a_process_that_states_no_figures_causes_no_words(load: object) -> None:
    """Catches: a traceback, or words of a stranger, by what a process of pictures may state."""
    assert load_advice(load) is None


@pytest.mark.parametrize("code", ["motion_gaps", "phase_gaps"])
def test_the_headline_names_the_cause(code: str) -> None:
    """Catches: a headline that advises a faster connection whatever was slow."""
    for load, words in (
        ({"judging_ms": 70.0, "pictures_per_s": 14.0}, "processor"),
        ({"judging_ms": 12.0, "pictures_per_s": 9.0}, "Only 9 pictures a second came"),
        ({"judging_ms": 12.0, "pictures_per_s": 30.0}, None),
        (None, None),
    ):
        event: dict[str, Any] = said("inconclusive", code, level="undecided", load=load)
        advice = headline(event).advice
        assert advice.startswith(SLOWLY) and (advice == SLOWLY if words is None else words in advice)
