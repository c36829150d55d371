"""Effects of the encoding: high dynamic range (HLG, PQ), calls that change their picture's size, and low quality."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from moireid.simulate.effects.effect import Effect, Kind
from moireid.simulate.recording.encode import Pass, Recipe

#: Rows that a call sends in turns, by its rate in kbit/s.
CALL_ROWS = {700: (720, 540), 350: (480, 360), 200: (360, 240)}


def _last(change: Callable[[Pass], Pass]) -> Effect:
    """The last encoding changed."""
    return Effect(recipe=lambda recipe: replace(recipe, passes=(*recipe.passes[:-1], change(recipe.passes[-1]))))


def dynamic(transfer: str, figure: float) -> Effect:
    """High dynamic range in 10-bit H.265 of this quality."""
    return _last(lambda one: replace(one, codec="h265", crf=int(figure), kbps=None, transfer=transfer))


def called(figure: float) -> Effect:
    """A call at this rate, whose picture changes its size, recorded at one size."""

    def recipe(before: Recipe) -> Recipe:
        call = Pass(kbps=int(figure), turns=CALL_ROWS[int(figure)])
        return replace(before, passes=(call, *before.passes))

    return Effect(recipe=recipe)


def poor(figure: float) -> Effect:
    """The last encoding at this quality."""
    return _last(lambda one: replace(one, crf=int(figure), kbps=None))


CODINGS = (
    Kind(
        "hlg",
        (18, 22, 28),
        "crf of 10-bit H.265, hybrid log-gamma",
        "phones record at more than 20 Mbit/s, as crf 18 and better do",
        lambda figure: dynamic("hlg", figure),
    ),
    Kind(
        "pq", (18, 22, 28), "crf of 10-bit H.265, perceptual quantiser", "HDR10", lambda figure: dynamic("pq", figure)
    ),
    Kind(
        "call",
        (700, 350, 200),
        "kbit/s of a call whose picture changes its size every 3 s",
        "call programs send 360 rows at 300 to 700 kbit/s",
        called,
    ),
    Kind("crf", (28, 34, 40), "crf of H.264", "23 is usual, services take 26 to 34", poor),
)
