"""The badge as built: measured at enrolment, and compared with that at verification.

A copy made from the same files has the same identity, but its sheet is placed differently: another offset,
another twist, and another beat if it was printed again; and each piece of sheet has lenses that are off their places
in its own way (`place_map`).  Weather changes the beat too: paper grows with humidity, along
its fibre less than across, and the sheet with warmth.  A sheet that is held at an edge then slides over the lines, so
the tolerance of the offset grows with the measured change of the beat.  The badge that was enrolled stays within what
moisture and warmth do independently; one that was built anew must be beyond both together.

So a film whose figures differ shows a badge that was built anew.  One whose figures agree need not show the badge that
was enrolled: a forger who computes a film can give it any figures.

The sheet is in one place all film long, so the offset must be the same in every stretch.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from moireid.asbuilt import MOST_MAP_RAD, MOST_MAP_SD_RAD, AsBuilt
from moireid.badge import Badge
from moireid.errors import DesignError
from moireid.frames import own_rect
from moireid.verifier import measuring
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.fringes.place_map import PlaceMap
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.decode import read_identity
from moireid.verifier.limits import BUILT_GAIN_ROOM_SHARE, GAINS_AGREE_SDS, INDEPENDENT_PER_S
from moireid.verifier.reasons import Reason
from moireid.verifier.tracking.track import Track

Array = NDArray[np.float64]
Built = Literal["agrees", "differs", "not_known"]
#: How a figure compares with enrolment, in words.
SEEN: dict[Built, str] = {
    "agrees": "is the same, but for errors that every film has",
    "not_known": "is a little different, and it is not clear why",
    "differs": "is another",
}
#: Value and standard deviation of a figure in `AsBuilt`, with its name and unit.
FIGURES = (
    ("beat", "cycles/mm", "beat_frequency_per_mm", "beat_frequency_sd"),
    ("offset", "rad", "offset_rad", "offset_sd"),
    ("twist", "rad/mm", "twist_rad_per_mm", "twist_sd"),
    ("gain", "", "gain_ratio", "gain_sd"),
)
#: Codes of a figure's comparison, and what it is of in words.  The gain is left out: `judge` compares it.
WORDS = {
    "as_built_beat": "the spacing of the fringes",
    "as_built_offset": "the place of the lens sheet",
    "as_built_twist": "the turn of the lens sheet",
    "as_built_map": "the pattern of the lens sheet's own errors",
}


@dataclass(frozen=True)
class FigurePair:
    """One figure of two sets, the known one and a new one.

    known, known_sd: None where none is known; difference: without sign, None likewise; room: how far weather usually
    moves it, and widest, how far at most; sd: of the difference, with what repetition does.
    """

    name: str
    unit: str
    known: float | None
    known_sd: float | None
    new: float
    new_sd: float
    difference: float | None = None
    room: float = 0.0
    widest: float = 0.0
    sd: float = 0.0

    @property
    def limit(self) -> float:
        """How large the difference of one build may be."""
        return self.room + measuring.AGREES_SDS * self.sd

    @property
    def level(self) -> Built:
        """Whether they are of one build; "not_known" lies between the limits of the other two."""
        if self.difference is None or self.difference <= self.limit:
            return "agrees"
        return "differs" if self.difference > self.widest + measuring.DIFFERS_SDS * self.sd else "not_known"

    @property
    def differs(self) -> bool:
        """Whether it is another figure."""
        return self.level != "agrees"

    @property
    def apart_sds(self) -> float | None:
        """The difference in error bars of both."""
        if self.difference is None or self.known_sd is None:
            return None
        return self.difference / max(math.hypot(self.known_sd, self.new_sd), 1e-12)

    @property
    def limit_sds(self) -> float | None:
        """How many error bars apart it may be."""
        return self.apart_sds * self.limit / self.difference if self.apart_sds and self.difference else None


@dataclass(frozen=True)
class Comparison:
    """Outcome of comparing a film's figures with those of enrolment.

    constant_room_rad: how far the fringes' phase constant may be from that at enrolment, where the film shows it there;
    else None.
    """

    built: Built
    reasons: tuple[Reason, ...]
    constant_room_rad: float | None = None


def filmed_built(
    track: Track, measurement: Measurement, gain: float, gain_sd: float, third_harmonic: float | None = None
) -> tuple[AsBuilt, Reason | None]:
    """The as-built figures measured from one film, and a finding where its stretches show several places of the sheet.

    Parameters: gain, gain_sd: the film's gain over the design, and its standard deviation; third_harmonic: as in
        `AsBuilt`.

    Convention: as `AsBuilt`; the gain is over the design.
    Raises: DesignError for a board that carries no identity.
    Source: `cell_phase.uniform_fields` of the first grating that carries a code.  The offset is the mean of measured
        phase less the film's own gain times the predicted one; its error comes from the scatter over time and from the
        gain's error times the mean phase.
    """
    badge = track.badge
    index = next((k for k, grating in enumerate(badge.gratings) if grating.code), None)
    if index is None:
        raise DesignError("a board without an identity cannot be enrolled as built; print a badge with one")
    reading = read_identity(track, measurement)
    field = reading.fields[index]
    code = badge.gratings[index].code
    assert code is not None
    reference = reading.cells[index][code.reference_cell]
    strips = zip(track.strips, measurement.strips, strict=True)
    law_rad = np.mean([seen.predicted_rad for strip, seen in strips if strip.grating == index and seen], axis=0)
    clock = np.exp(1j * (field.clock_rad - (gain - 1) * law_rad))
    mean_turn = complex(clock.mean())
    wander = float(np.std(np.angle(clock / mean_turn)))
    seconds = float(measurement.times_s[-1] - measurement.times_s[0])
    off_centre = abs(float(law_rad.mean()))
    offset_sd = math.hypot(wander / math.sqrt(max(INDEPENDENT_PER_S * seconds, 1.0)), off_centre * gain_sd)
    _, top, _, bottom = own_rect(badge.gratings[index].axis, badge.gratings[index].rect_mm)
    as_built = AsBuilt(
        # A sealed claim has a specimen of the layout, which has no identity.
        badge_id=badge.id or "",
        beat_frequency_per_mm=reference.frequency_per_mm,
        beat_frequency_sd=reference.frequency_sd,
        offset_rad=float(np.angle(mean_turn)),
        offset_sd=offset_sd,
        twist_rad_per_mm=field.twist_rad_per_mm,
        twist_sd=measuring.ROW_OFFSET_SD_RAD / (bottom - top),
        gain_ratio=gain,
        gain_sd=gain_sd,
        third_harmonic=third_harmonic,
        **_filmed_maps(measurement.maps),
    )
    apart = np.angle(clock * np.conj(mean_turn))
    return as_built, _moved_sheet(*_worst_stretch(apart, law_rad, measurement.gratings[index], gain_sd))


def _filmed_maps(maps: Sequence[PlaceMap]) -> dict[str, Any]:
    """The maps as `AsBuilt` holds them; none where a grating does not show its own."""
    if not all(0 < one.sd_rad <= MOST_MAP_SD_RAD and np.abs(one.seen_rad).max() <= MOST_MAP_RAD for one in maps):
        return {}
    values = tuple(tuple(round(float(value), 4) for value in one.seen_rad) for one in maps)
    return {"place_maps": values, "place_map_sd": max(one.sd_rad for one in maps)}


def _worst_stretch(apart: Array, law_rad: Array, signal: GratingSignal, gain_sd: float) -> tuple[float, float]:
    """The offset of the worst stretch less that of the film, and its standard deviation, rad.

    Parameters: apart (T,): measured phase less the film's own gain times the predicted one, `law_rad` (T,), less its
        mean over the film.
    """
    if signal.stretch[0] == signal.stretch[-1]:
        return 0.0, 1.0
    used = np.isfinite(signal.phase_sd_rad)
    aside = law_rad - float(law_rad[used].mean())
    worst = 0.0, 1.0
    for number in np.unique(signal.stretch[used]):
        part = used & (signal.stretch == number)
        seconds = float(np.ptp(signal.times_s[part]))
        if seconds < measuring.LEAST_STRETCH_S:
            continue
        scatter = float(apart[part].std()) / math.sqrt(max(INDEPENDENT_PER_S * seconds, 1.0))
        sd = math.hypot(scatter, abs(float(aside[part].mean())) * gain_sd, measuring.OFFSET_REPEATS_RAD)
        worst = max(worst, (abs(float(apart[part].mean())), sd), key=lambda found: found[0] / found[1])
    return worst


def _moved_sheet(apart_rad: float, sd_rad: float) -> Reason | None:
    """The finding on a sheet that is not in one place all film long; parameters: of the worst stretch."""
    limit = measuring.AGREES_SDS * sd_rad
    if apart_rad <= limit:
        return None
    text = "Between parts of the film the lens sheet seems to lie in different places."
    return Reason("as_built_stretches", "note", apart_rad, limit, "rad", text)


def agree(new: AsBuilt, known: AsBuilt, badge: Badge) -> dict[str, FigurePair]:
    """Whether two sets of figures are of one build: each figure, by its name, with how far apart it may be.

    Convention: limits in standard deviations of the repeatability, plus what weather does (module docstring); of the
        gain `GAINS_AGREE_SDS`, or a share of the known one.
    """
    grating = next(grating for grating in badge.gratings if grating.code)
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    half_mm = (high - low) / 2
    lines_per_mm = 1.0 / badge.lens.pitch_mm
    paper = float(badge.frame_of(grating).growths(measuring.PAPER_GROWTH_SHARE)[0])
    sheet = measuring.SHEET_GROWTH_PER_K * measuring.WEATHER_K
    usual, most = math.hypot(paper, sheet) * lines_per_mm, (paper + sheet) * lines_per_mm
    beat = abs(new.beat_frequency_per_mm - known.beat_frequency_per_mm)
    offset = abs(math.remainder(new.offset_rad - known.offset_rad, 2 * math.pi))
    twist = abs(new.twist_rad_per_mm - known.twist_rad_per_mm)
    slide_rad = 2 * math.pi * half_mm * min(beat, most)
    gain_sd = math.hypot(known.gain_sd, new.gain_sd)
    gain_room = max(GAINS_AGREE_SDS * gain_sd, BUILT_GAIN_ROOM_SHARE * known.gain_ratio)
    # Difference, what weather does usually and at most, and what repetition does; None: as much as the room says.
    limits: dict[str, tuple[float, float, float, float | None]] = {
        "beat": (beat, usual, most, measuring.MIN_FREQUENCY_SD_PER_MM),
        "offset": (offset, slide_rad, slide_rad, measuring.OFFSET_REPEATS_RAD),
        "twist": (twist, 0.0, 0.0, 2 * math.pi * measuring.TWIST_REPEATS_RAD * lines_per_mm),
        "gain": (abs(new.gain_ratio - known.gain_ratio), gain_room, gain_room, None),
    }
    pairs = {}
    for name, unit, value, deviation in FIGURES:
        known_sd, new_sd = getattr(known, deviation), getattr(new, deviation)
        difference, room, widest, repeats = limits[name]
        sd = 0.0 if repeats is None else math.hypot(new_sd, known_sd, repeats)
        pairs[name] = FigurePair(
            name, unit, getattr(known, value), known_sd, getattr(new, value), new_sd, difference, room, widest, sd
        )
    if maps := _maps_apart(new, known):
        pairs["map"] = maps
    return pairs


def compare_built(found: AsBuilt, enrolled: AsBuilt, badge: Badge, moved: Reason | None = None) -> Comparison:
    """Whether the figures of a film are those that were measured at enrolment.

    Parameters: moved: the finding of `filmed_built`.

    Source: `agree`, but for the gain.
    """
    pairs = agree(found, enrolled, badge)
    reasons, levels = [], []
    for code, words in WORDS.items():
        if (pair := pairs.get(code.removeprefix("as_built_"))) is not None:
            levels.append(pair.level)
            text = f"Compared with its enrolment, {words} {SEEN[pair.level]}."
            reasons.append(Reason(code, "note", pair.difference, pair.limit, pair.unit, text))
    if moved is not None:
        levels.append("not_known")
        reasons.append(moved)
    built: Built = "differs" if "differs" in levels else "not_known" if "not_known" in levels else "agrees"
    if built != "agrees":
        return Comparison(built, tuple(reasons))
    gain_sd = math.hypot(found.gain_sd, enrolled.gain_sd)
    offset = pairs["offset"]
    room = offset.room + measuring.KNOWN_SDS * offset.sd
    sure = (
        abs(found.gain_ratio - enrolled.gain_ratio) <= measuring.KNOWN_SDS * gain_sd
        and (offset.difference or 0) <= room
    )
    return Comparison(built, tuple(reasons), room if sure else None)


def _maps_apart(new: AsBuilt, known: AsBuilt) -> FigurePair | None:
    """Root mean square between the maps of two sets, rad; None if they are unknown.

    Its standard deviation is that with what a noisy film may claim of it (`MAP_MOST_SD_RAD`); in full only where the
    maps are to differ.  Weather does not change a map: what grows evenly has a mean and a slope alone, which a map has
    not.
    """
    if new.place_map_sd is None or known.place_map_sd is None:
        return None
    both = zip(new.place_maps, known.place_maps, strict=True)
    apart = [one - other for row, before in both for one, other in zip(row, before, strict=True)]
    off = math.sqrt(sum(value**2 for value in apart) / len(apart))
    rest = math.hypot(known.place_map_sd, measuring.MAP_REPEATS_RAD)
    sure_sd, sd = (
        math.hypot(own, rest) for own in (min(new.place_map_sd, measuring.MAP_MOST_SD_RAD), new.place_map_sd)
    )
    widest = measuring.DIFFERS_SDS * (sd - sure_sd)
    return FigurePair("map", "rad", 0.0, known.place_map_sd, off, new.place_map_sd, off, 0.0, widest, sure_sd)
