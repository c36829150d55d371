"""Photographs of the badge instead of the badge: rows of the table of explanations, and their findings.

| row | the fringes are those of | finding |
|---|---|---|
| `photographs_at_one_distance` | photographs from one distance, moved by the law | `spacing` |
| `photographs_in_turn` | two to four photographs, in turn or cross-faded | `cross_fade` |
| `photographs_laid_over` | photographs, all superposed | `third_harmonic` |

A zoom within the film, a shadow that moves, or air under the sheet can do the same to a true badge, so none of them
rejects a film.

Convention: a row's figure is that of the grating that looks most like photographs.
"""

from __future__ import annotations

from collections.abc import Sequence

from moireid.verifier import limits
from moireid.verifier.decision.comparison import Explanation
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain
from moireid.verifier.explanations.photographs.cross_fade import CrossFade, cross_fade_of
from moireid.verifier.explanations.photographs.fringe_spacing import Spacing
from moireid.verifier.explanations.photographs.third_harmonic import ThirdHarmonic, third_harmonic_of
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.reasons import Level, Reason

#: A row of the table, if there is one, and its finding.
RowAndReason = tuple[Explanation | None, Reason]


def photographs(
    spacing: Spacing | None, moved: Sequence[GratingSignal], sheet: SheetGain = DESIGNED
) -> tuple[tuple[Explanation, ...], list[Reason]]:
    """The rows and findings on photographs.

    Parameters: spacing: of all gratings, None where the distance does not change; moved: signals that moved enough;
        sheet: how sharp the fringes must be.
    """
    rows = [] if spacing is None else [_at_one_distance(spacing)]
    fades = [fade for signal in moved if (fade := cross_fade_of(signal)) is not None]
    if fades:
        rows.append(_in_turn(max(fades, key=lambda one: one.certain)))
    sharp = sheet.least_overtone / limits.MIN_OVERTONE_CONTRASTS
    harmonics = [one.asked(sharp) for signal in moved if (one := third_harmonic_of(signal)) is not None]
    if harmonics:
        rows.append(_superposed(min(harmonics, key=lambda one: one.surplus / one.limit)))
    return tuple(row for row, _ in rows if row is not None), [reason for _, reason in rows]


def _at_one_distance(spacing: Spacing) -> RowAndReason:
    level: Level = "undecided" if spacing.wrong else "pass" if spacing.tested else "note"
    seen = "As the badge comes nearer or goes away, the spacing of its fringes"
    text = {
        "undecided": f"{seen} does not follow, as on photographs over a film, or under a zoom. Film without zoom.",
        "pass": f"{seen} follows, which that of photographs from one distance does not.",
        "note": "The distance hardly changed, so the film does not show whether the fringes' spacing follows it.",
    }[level]
    reason = Reason(
        "spacing", level, None if level == "note" else spacing.gain, limits.MAX_SPACING_ERROR_RATIO, "ratio", text
    )
    if level == "note":
        return None, reason
    parameters = {"spacing_gain": spacing.gain}
    return Explanation("photographs_at_one_distance", spacing.log10_odds, parameters, None, spacing.wrong), reason


def _in_turn(fade: CrossFade) -> RowAndReason:
    level: Level = "undecided" if fade.seen else "pass"
    text = "The fringes keep their shape all along their way."
    if fade.seen:
        text = f"The fringes change their shape as those of {fade.photographs} photographs do that are shown in turn, "
        text += "or one faded into the other. Film in even light, and keep the badge moving."
    parameters = {"photographs": float(fade.photographs), "form_share": fade.share}
    row = Explanation("photographs_in_turn", fade.log10_odds, parameters, None, fade.seen)
    return row, Reason("cross_fade", level, fade.certain, limits.MAX_CROSS_FADE_SHARE, "share", text)


def _superposed(harmonic: ThirdHarmonic) -> RowAndReason:
    level: Level = "pass" if harmonic.seen else "undecided"
    text = "The fringes have sharp edges, as lenses make them."
    if not harmonic.seen:
        text = "The fringes lack the sharp edges that lenses make, as in a blurred picture, in superposed "
        text += "photographs, or under a sheet with air beneath it. "
        text += "Film from nearer, in focus, with the sheet pressed flat."
    parameters = {"third_harmonic": harmonic.surplus, "let_through": harmonic.let_through}
    row = Explanation("photographs_laid_over", harmonic.log10_odds, parameters, None, not harmonic.seen)
    return row, Reason("third_harmonic", level, harmonic.surplus, harmonic.limit, "contrasts", text)
