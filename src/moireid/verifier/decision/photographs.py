"""Photographs of the badge instead of the badge: do the fringes' spacing and shape follow the law, too?

| finding | the fringes may be those of |
|---|---|
| `spacing` | photographs from one distance, moved by the law |
| `cross_fade` | two to four photographs, in turn or cross-faded |
| `third_harmonic` | photographs, all superposed |

A zoom within the film, a shadow that moves, or air under the sheet can do the same to a true badge, so none of them
rejects a film.

Convention: a figure is that of the grating that looks most like photographs.
"""

from __future__ import annotations

from collections.abc import Sequence

from moireid.verifier import limits
from moireid.verifier.explanations.photographs.cross_fade import CrossFade, cross_fade_of
from moireid.verifier.explanations.photographs.fringe_spacing import Spacing
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic, third_harmonic_of
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.reasons import Level, Reason


def softest(moved: Sequence[GratingSignal]) -> ThirdHarmonic | None:
    """The third harmonic of the grating that has least of it, first of those that miss it; None if not known."""
    harmonics = [one for signal in moved if (one := third_harmonic_of(signal)) is not None]
    return min(harmonics, key=lambda one: (not one.missed, one.surplus / one.limit), default=None)


def photographs(
    spacing: Spacing | None, moved: Sequence[GratingSignal], harmonic: ThirdHarmonic | None
) -> list[Reason]:
    """The findings on photographs.

    Parameters: spacing: of all gratings, None where the distance does not change; moved: signals that moved enough;
        harmonic: as `softest`.
    """
    fades = [fade for signal in moved if (fade := cross_fade_of(signal)) is not None]
    found = [] if spacing is None else [_at_one_distance(spacing)]
    found += [_in_turn(max(fades, key=lambda one: one.certain))] if fades else []
    return found + ([] if harmonic is None else [_superposed(harmonic)])


def _at_one_distance(spacing: Spacing) -> Reason:
    level: Level = "undecided" if spacing.wrong else "pass" if spacing.tested else "note"
    seen = "As the badge comes nearer or goes away, the spacing of its fringes"
    text = {
        "undecided": f"{seen} does not follow, as on photographs over a film, or under a zoom. Film without zoom.",
        "pass": f"{seen} follows, which that of photographs from one distance does not.",
        "note": "The distance hardly changed, so the film does not show whether the fringes' spacing follows it.",
    }[level]
    measured = None if level == "note" else spacing.gain
    return Reason("spacing", level, measured, limits.MAX_SPACING_ERROR_RATIO, "ratio", text)


def _in_turn(fade: CrossFade) -> Reason:
    text = "The fringes keep their shape all along their way."
    if fade.seen:
        text = f"The fringes change their shape as those of {fade.photographs} photographs do that are shown in turn, "
        text += "or one faded into the other. Film in even light, and keep the badge moving."
    level: Level = "undecided" if fade.seen else "pass"
    return Reason("cross_fade", level, fade.certain, limits.MAX_CROSS_FADE_SHARE, "share", text)


def _superposed(harmonic: ThirdHarmonic) -> Reason:
    level: Level = "undecided" if harmonic.missed else "pass" if harmonic.seen else "note"
    text = {
        "undecided": "The fringes lack the sharp edges that lenses make, though the page's own edges are sharp enough: "
        "as in superposed photographs, under a soft sheet, or with air beneath it. Film from nearer, with the sheet "
        "pressed flat.",
        "pass": "The fringes have sharp edges, as lenses make them.",
        "note": "The picture is too soft to show whether the fringes have the sharp edges that lenses make.",
    }[level]
    return Reason("third_harmonic", level, harmonic.surplus, harmonic.limit, "contrasts", text)
