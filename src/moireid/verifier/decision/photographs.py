"""Could the film show photographs of the badge?  Rows of the table of explanations, and findings.

| row | the fringes are those of | finding |
|---|---|---|
| `photographs_at_one_distance` | photographs from one distance, moved by the law | `spacing` |
| `photographs_in_turn` | two to four photographs, in turn or cross-faded | `cross_fade` |
| `photographs_faded` | more photographs, cross-faded | `waveform` |
| `photographs_laid_over` | photographs, all laid over each other | `third_harmonic` |

A zoom within the film, a shadow that moves, or air under the sheet can do the same to a true badge, so none of them
rejects a film.

Convention: as `comparison`; a row's figure is that of the grating that looks most like photographs.
"""

from __future__ import annotations

from collections.abc import Sequence

from moireid.verifier.decision.comparison import Explanation
from moireid.verifier.explanations.photographs.cross_fade import CrossFade, cross_fade_of
from moireid.verifier.explanations.photographs.spacing import Spacing
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic
from moireid.verifier.explanations.photographs.waveform import MOST_PHOTOGRAPHS, Waveform, waveform_of
from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import MAX_CROSS_FADE_SHARE, MAX_SPACING_ERROR_RATIO
from moireid.verifier.reasons import Level, Reason

#: A row of the table, and the finding that says the same.
Told = tuple[Explanation | None, Reason]


def photographs(
    spacing: Spacing | None, moved: Sequence[GratingSignal]
) -> tuple[tuple[Explanation, ...], list[Reason]]:
    """The rows and findings on photographs, and how many photographs would make such a film.

    Parameters: spacing: of all gratings, None where the distance does not change; moved: signals that moved enough.
    """
    told = [] if spacing is None else [_at_one_distance(spacing)]
    fades = [fade for signal in moved if (fade := cross_fade_of(signal)) is not None]
    if fades:
        told.append(_in_turn(max(fades, key=lambda one: one.certain)))
    waveforms = [waveform for signal in moved if (waveform := waveform_of(signal)) is not None]
    if waveforms:
        told.append(_faded(max(waveforms, key=lambda one: one.ripple / one.limit)))
        harmonics = [one.third_harmonic for one in waveforms if one.third_harmonic is not None]
        if harmonics:
            told.append(_laid_over(min(harmonics, key=lambda one: one.surplus / one.limit)))
        count = max(one.photographs for one in waveforms)
        told.append((None, _needed(count, from_two=spacing is not None and spacing.tested and not spacing.wrong)))
    return tuple(row for row, _ in told if row is not None), [reason for _, reason in told]


def _row(name: str, odds: float | None, parameters: dict[str, float], level: Level) -> Explanation:
    return Explanation(name, odds, parameters, None, level == "undecided")


def _at_one_distance(spacing: Spacing) -> Told:
    level: Level = "undecided" if spacing.wrong else "pass" if spacing.tested else "note"
    seen = "As the badge comes nearer or goes away, the spacing of its fringes"
    text = {
        "undecided": f"{seen} does not follow, as on photographs laid over a film, or under a zoom. Film without zoom.",
        "pass": f"{seen} follows, which that of photographs from one distance does not.",
        "note": "The distance hardly changed, so the film does not show whether the fringes' spacing follows it.",
    }[level]
    gain = None if level == "note" else spacing.gain
    reason = Reason("spacing", level, gain, MAX_SPACING_ERROR_RATIO, "ratio", text)
    row = _row("photographs_at_one_distance", spacing.log10_odds, {"spacing_gain": spacing.gain}, level)
    return None if level == "note" else row, reason


def _in_turn(fade: CrossFade) -> Told:
    level: Level = "undecided" if fade.seen else "pass"
    text = "The fringes keep their shape all along their way."
    if fade.seen:
        text = f"The fringes change their shape as those of {fade.photographs} photographs do that are shown in turn, "
        text += "or one faded into the other. Film in even light, and keep the badge moving."
    parameters = {"photographs": float(fade.photographs), "form_share": fade.share}
    row = _row("photographs_in_turn", fade.log10_odds, parameters, level)
    return row, Reason("cross_fade", level, fade.certain, MAX_CROSS_FADE_SHARE, "share", text)


def _faded(waveform: Waveform) -> Told:
    level: Level = "pass" if waveform.ripple <= waveform.limit else "undecided"
    text = "The fringes keep their shape from place to place."
    if level == "undecided":
        text = "The fringes change their shape from place to place, as between cross-faded photographs. "
        text += "Film in even light."
    row = _row("photographs_faded", None, {"photographs": float(waveform.photographs)}, level)
    return row, Reason("waveform", level, waveform.ripple, waveform.limit, "contrasts", text)


def _laid_over(harmonic: ThirdHarmonic) -> Told:
    level: Level = "pass" if harmonic.seen else "undecided"
    text = "The fringes have sharp edges, as lenses make them."
    if not harmonic.seen:
        text = "The fringes lack the sharp edges that lenses make, as in a blurred picture, in photographs laid over "
        text += "each other, or under a sheet with air beneath it. "
        text += "Film from nearer, in focus, with the sheet pressed flat."
    row = _row("photographs_laid_over", harmonic.log10_odds, {"third_harmonic": harmonic.surplus}, level)
    return row, Reason("third_harmonic", level, harmonic.surplus, harmonic.limit, "contrasts", text)


def _needed(count: int, *, from_two: bool) -> Reason:
    least = f"at least {count}" if count < MOST_PHOTOGRAPHS else f"more than {count}"
    text = f"To fake this film by cross-fading photographs of the badge, a forger would need {least} along its course"
    # One from another distance may be all that the spacing asks for, so it adds nothing to the count.
    text += ", and some from another distance." if from_two else "."
    return Reason("photographs", "note", float(count), None, "photographs", text)
