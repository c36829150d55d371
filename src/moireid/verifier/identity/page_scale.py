"""Is the page off its size, or the sheet off its pitch?

A page that is printed at 97 %, or a sheet of the next common pitch, has fringes too, but other ones: wider, narrower,
or of the right width and mirrored.  Mirrored fringes run backwards, and so do those of a film that was played
backwards; but a page or sheet mirrors the differences of all rows and the phases of all cells with them, so that the
code spells an identity in a mirror, which a film that is played backwards does not do.

Convention: scale is that of the page over that of the sheet, each over its design: 1 where both are right.
Source: in page units the beat is 1/p_r - scale/p_f, so a scale s adds (1 - s)/p_f to all beats alike; a beat of the
    other sign is measured with the sign that was searched for, and so with the opposite phase.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from moireid.badge import Badge
from moireid.idcodes import CellReading, family_named, specimen_of
from moireid.verifier.fringes.all_strips import search_band_per_mm
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.fringes.strip_law import strip_law
from moireid.verifier.fringes.strip_phase import strongest_frequency
from moireid.verifier.measuring import PITCH_TOLERANCE_SHARE
from moireid.verifier.reasons import Reason
from moireid.verifier.tracking.track import Track

#: Scales that are looked for, off 1 by so much at most.  Derived: "fit to page" prints A4 on letter at 94 %, and
#: sheets of common pitches differ by 3 % and more.
MOST_OFF_SHARE = 0.06
#: Fringes must explain this share of a row's pattern.  Set by hand: those of printed lines have four fifths of it.
LEAST_EXPLAINED_SHARE = 0.5
ADVICE = "Measure the bars on the page and the pitch of the sheet; print at 100 %."


def page_scale(
    track: Track, measurement: Measurement, cells: Sequence[Sequence[CellReading]], *, backwards: bool
) -> Reason | None:
    """The finding that page or sheet is off, of a film whose code spells no identity; None where nothing shows that.

    Parameters
    ----------
    track : Track
        Of its badge only the layout is used.
    measurement : Measurement
        Of the film.
    cells : sequence of sequence of CellReading
        Of each grating, as they were read.
    backwards : bool
        Whether the fringes move the other way than by the law.
    """
    scale = mirrored_scale(track.badge, cells) if backwards else None
    if scale is not None:
        return mirrored_finding(scale)
    beat = beat_elsewhere_per_mm(track, measurement)
    if beat is None:
        return None
    text = (
        f"The fringes repeat every {1 / beat:.3g} mm, which those of no such badge do: the page is not printed at its "
        f"size, or the sheet has another pitch. {ADVICE}"
    )
    return Reason("page_scale", "undecided", 1 / beat, None, "mm", text)


def mirrored_finding(scale: float) -> Reason:
    """The finding that the code can be read in a mirror alone."""
    text = (
        f"The badge's code can be read in a mirror alone, as on a page printed at {100 * scale:.1f} % of its size, or "
        f"under a sheet whose lenses are {100 / scale - 100:.1f} % too wide. {ADVICE}"
    )
    return Reason("page_scale", "undecided", scale, PITCH_TOLERANCE_SHARE, "ratio", text)


def mirrored_scale(badge: Badge, cells: Sequence[Sequence[CellReading]]) -> float | None:
    """The scale at which a code that is read in a mirror spells an identity; None where it spells none."""
    coded = [index for index, grating in enumerate(badge.gratings) if grating.code]
    if not coded:
        return None
    gratings = tuple(badge.gratings[index] for index in coded)
    mirrored = [
        [replace(one, frequency_per_mm=-one.frequency_per_mm, phase_rad=-one.phase_rad) for one in cells[index]]
        for index in coded
    ]
    found = family_named(gratings[0].family).read(mirrored, gratings)
    if found.payload is None or found.beats_agree is False:
        return None
    own = specimen_of(badge, found.payload.hex())
    front = badge.lens.pitch_mm
    apart = [
        one.frequency_per_mm - (1 / cell.pitch_mm - 1 / front)
        for index, row in zip(coded, mirrored, strict=True)
        for one, cell in zip(row, own.gratings[index].cells, strict=True)
        if np.isfinite(one.frequency_per_mm)
    ]
    return 1 - float(np.median(apart)) * front if apart else None


def beat_elsewhere_per_mm(track: Track, measurement: Measurement) -> float | None:
    """The beat that most rows show outside of what any badge of this layout may have, 1/mm, > 0; None for none."""
    badge, found = track.badge, []
    most = MOST_OFF_SHARE / badge.lens.pitch_mm
    for profiles, strip in zip(track.profiles, track.strips, strict=True):
        grating = badge.gratings[strip.grating]
        if not strip.uniform or grating.code is None:
            continue
        law = strip_law(badge, strip, measurement.camera_mm)
        low, high = search_band_per_mm(badge, grating, strip.cells[0])
        # Beats of both signs look alike in a picture, so those on the layout's side of 0 are tried.
        band = (low - most, max(high, 0.0)) if low < 0 else (min(low, 0.0), high + most)
        beat, share = strongest_frequency(profiles.astype(float), law, strip.length_mm, band)
        inside = low <= beat <= high or low <= -beat <= high
        found.append((abs(beat), inside, share))
    elsewhere = [beat for beat, inside, share in found if not inside and share >= LEAST_EXPLAINED_SHARE and beat > 0]
    return float(np.median(elsewhere)) if 2 * len(elsewhere) > len(found) else None
