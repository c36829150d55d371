"""AsBuilt: figures of one built badge, measured from films at enrolment.

Markers are printed with the lines, so everything is in page units: the beat of the reference cell (the ratio of page to
lens pitch), the gain, and how the sheet is placed on the page.  A film shows neither true millimetres nor print scale
and lens pitch separately; a ruler's reading of the scale bar may be recorded too.

Convention: phases as `moireid.verifier.identity.cell_phase.Field`; every figure with its standard deviation.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Annotated, Any

from msgspec import Meta

from moireid.errors import SpecError
from moireid.models import check_format, parse_json, read_model

FORMAT = 1
#: Of the camera and the page by which figures are measured: two terms of radial distortion, a page that may be twisted,
#: and a map of places.
MODEL = 2
#: Bounds of a map of places and of its standard deviation, rad: beyond, a film shows none.
MOST_MAP_RAD, MOST_MAP_SD_RAD = 10.0, 1.0
#: One below 0 would count by its size where figures are compared, and by its sign where they are chosen.
Deviation = Annotated[float, Meta(ge=0)]


@dataclass(frozen=True)
class AsBuilt:
    """Figures of one built badge.

    beat_frequency_per_mm: of the reference cell, signed, cycles per mm of page, camera far away; offset_rad: fringe
    phase in the middle of the first grating at zero parallax, which depends on how the sheet was placed;
    twist_rad_per_mm: slope of that phase along the lenses; gain_ratio: measured over predicted motion; captures: number
    of films used; measured_scale: a ruler's reading over the printed length, or None; third_harmonic: how much of the
    fringes' third harmonic turns with them, contrasts, seen from the front; None where it was not measured; place_maps:
    for each grating, how far the fringes are ahead of the law at its knots (`fringes.place_map`), rad; none where they
    were not measured; place_map_sd: standard deviation of a knot;
    witnessed: whether they were measured in live checks alone, in which the badge followed prompts drawn at random, or
    one of those agreed with them.
    """

    badge_id: str
    beat_frequency_per_mm: float
    beat_frequency_sd: Deviation
    offset_rad: float
    offset_sd: Deviation
    twist_rad_per_mm: float
    twist_sd: Deviation
    gain_ratio: float
    gain_sd: Deviation
    captures: int = 1
    measured_scale: float | None = None
    third_harmonic: float | None = None
    place_maps: tuple[tuple[Annotated[float, Meta(ge=-MOST_MAP_RAD, le=MOST_MAP_RAD)], ...], ...] = ()
    place_map_sd: Annotated[float, Meta(gt=0, le=MOST_MAP_SD_RAD)] | None = None
    witnessed: bool = False

    def __repr__(self) -> str:
        """Short, without the maps of places."""
        beat = f"beat {self.beat_period_mm:.2f} mm" if self.beat_frequency_per_mm else "no beat"
        gain = f"gain {self.gain_ratio:.3f} ± {self.gain_sd:.3f}"
        return f"AsBuilt({self.badge_id!r}, {beat}, {gain}, {self.captures} captures)"

    @property
    def beat_period_mm(self) -> float:
        """Beat period of the reference cell in page mm, always positive."""
        return 1.0 / abs(self.beat_frequency_per_mm)

    def to_json(self) -> str:
        """As JSON text, with the numbers of format and model."""
        return json.dumps({"format": FORMAT, "model": MODEL} | asdict(self))


def as_built_from_json(text: str) -> AsBuilt:
    """Read the JSON text.  Raises: SpecError if it does not have this format."""
    source, advice = "as-built figures", "enroll the badge with a capture again"
    document = parse_json(text, source, advice)
    check_format(document, FORMAT, source)
    found = read_model(document, AsBuilt, source, advice)
    if document.get("model") != MODEL:
        raise SpecError(f"{source}: model {document.get('model')} is not that of this version, {MODEL}; {advice}")
    if bool(found.place_maps) != (found.place_map_sd is not None):
        raise SpecError(f"{source}: place_maps and place_map_sd must be both there or both absent; {advice}")
    if found.beat_frequency_per_mm == 0:
        raise SpecError(f"{source}: beat_frequency_per_mm must not be 0, which has no period; {advice}")
    return found


@dataclass(frozen=True)
class DatedFigures:
    """A set of as-built figures that was in use before others took its place; at: since when it is on record, UTC,
    ISO 8601.
    """

    as_built: AsBuilt
    at: str


def dated_figures(sets: list[dict[str, Any]]) -> tuple[DatedFigures, ...]:
    """Sets of figures as a registry or a bundle holds them.  Raises: SpecError if one has another format."""
    return tuple(DatedFigures(as_built_from_json(json.dumps(one["as_built"])), str(one["as_built_at"])) for one in sets)


def merge(parts: list[AsBuilt]) -> AsBuilt:
    """Several captures of one badge combined: weighted means, with error bars at least as large as their spread.

    Raises: SpecError if they are of different badges, or there are none.
    """
    if not parts or len({part.badge_id for part in parts}) != 1:
        raise SpecError("captures to merge must be of one badge, and at least one is needed")
    figures: dict[str, Any] = {}
    for value, sd in (
        ("beat_frequency_per_mm", "beat_frequency_sd"),
        ("offset_rad", "offset_sd"),
        ("twist_rad_per_mm", "twist_sd"),
        ("gain_ratio", "gain_sd"),
    ):
        values = [getattr(part, value) for part in parts]
        if value == "offset_rad":
            # Offsets are angles on a circle, so average their differences from the first one.
            values = [values[0] + math.remainder(v - values[0], 2 * math.pi) for v in values]
        weights = [1.0 / max(getattr(part, sd), 1e-12) ** 2 for part in parts]
        mean = sum(w * v for w, v in zip(weights, values, strict=True)) / sum(weights)
        spread = math.sqrt(sum(w * (v - mean) ** 2 for w, v in zip(weights, values, strict=True)) / sum(weights))
        figures[value] = math.remainder(mean, 2 * math.pi) if value == "offset_rad" else mean
        figures[sd] = max(1.0 / math.sqrt(sum(weights)), spread / math.sqrt(len(parts)))
    scale = next((part.measured_scale for part in parts if part.measured_scale), None)
    sharp = min((part.third_harmonic for part in parts if part.third_harmonic is not None), default=None)
    return AsBuilt(
        parts[0].badge_id,
        **figures,
        captures=sum(part.captures for part in parts),
        measured_scale=scale,
        third_harmonic=sharp,
        witnessed=all(part.witnessed for part in parts),
        **_merged_maps(parts),
    )


def _merged_maps(parts: list[AsBuilt]) -> dict[str, Any]:
    """Weighted mean of the maps, with an error bar at least as large as their spread; nothing where none is known."""
    known = [
        (part.place_maps, part.place_map_sd) for part in parts if part.place_maps and part.place_map_sd is not None
    ]
    if not known:
        return {}
    if len({tuple(len(row) for row in maps) for maps, _ in known}) > 1:
        raise SpecError("captures to merge have maps of different places; they must be of one badge")
    weights = [1.0 / max(sd, 1e-12) ** 2 for _, sd in known]
    each = [[value for row in maps for value in row] for maps, _ in known]
    mean = [sum(w * v for w, v in zip(weights, at, strict=True)) / sum(weights) for at in zip(*each, strict=True)]
    spread = math.sqrt(
        sum(w * (v - m) ** 2 for w, one in zip(weights, each, strict=True) for v, m in zip(one, mean, strict=True))
        / (sum(weights) * len(mean))
    )
    values = iter(round(value, 4) for value in mean)
    return {
        "place_maps": tuple(tuple(next(values) for _ in row) for row in known[0][0]),
        "place_map_sd": max(1.0 / math.sqrt(sum(weights)), spread / math.sqrt(len(known))),
    }
