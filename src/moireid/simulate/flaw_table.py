"""What print, sheet, assembly and light do to a built badge: each flaw's unit, range and meaning, and builds by name.

Numbers and words only, so that the command's help can read this without loading the simulator.

Source: ink: a line of one dot of a 1200 dpi laser measured 42 to 64 um wider than drawn.  Focus: sheets for pictures
that flip are made 1.27 (three pictures) and 1.47 times (two) their focal radius, US6726858.  Ellipse: SPIE 5874-06,
US6795250.  Gradient: a sheet shrinks unevenly as it is extruded, US8192654.  Air of 0.05 mm, wander of 0.02 mm and haze
of 30 % are of an ordinary badge, set by hand; 0.15 mm, 0.05 mm and 60 % are where badges were still enrolled, or just
not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from moireid.errors import SpecError


class Flaw(NamedTuple):
    """One quantity of a build: its field of `Build`, unit, least and greatest value, and meaning in a few words.

    factor: of the field's value over that of the option.
    """

    field: str
    unit: str
    low: float
    high: float
    meaning: str
    factor: float = 1.0


_PER_DEGREE = math.pi / 180

#: By the name of the option.
FLAWS = {
    "ink": Flaw("ink_um", "um", 0, 300, "lines are wider by this, both edges together"),
    "banding": Flaw("banding", "share", 0, 0.3, "bands across the page, brighter and darker"),
    "print-scale": Flaw("print_scale", "ratio", 0.9, 1.1, "printed over nominal width"),
    "feed": Flaw("print_aspect", "ratio", 0.9, 1.1, "printed height over width, over the design's"),
    "focus": Flaw("focus_ratio", "ratio", 0.7, 2, "lens radius over that which focuses on its back"),
    "ellipse": Flaw("conic", "", -1, 0.5, "conic constant of lenses; 0: round"),
    "thickness": Flaw("thickness_ratio", "ratio", 0.3, 3, "real over nominal thickness of the sheet"),
    "lens-scale": Flaw("lens_scale", "ratio", 0.9, 1.1, "real over nominal pitch of the sheet"),
    "gradient": Flaw("pitch_gradient", "share", -0.05, 0.05, "change of the pitch from edge to edge"),
    "wander": Flaw("wander_mm", "mm", 0, 0.3, "rms by which lenses are off, over 25 mm or so"),
    "jitter": Flaw("pitch_jitter", "share", 0, 0.05, "rms of each lens's width, by itself"),
    "haze": Flaw("haze", "share", 0, 1, "light that is mixed from 3 mm around"),
    "offset": Flaw("lens_offset_mm", "mm", -10, 10, "how far the sheet is moved across its lenses"),
    "turn": Flaw("twist_rad", "deg", -10, 10, "how far the sheet is turned on the page", _PER_DEGREE),
    "air": Flaw("air_gap_mm", "mm", 0, 2, "air between sheet and page"),
    "air-waves": Flaw("air_wave_mm", "mm", 0, 0.5, "rms of its change, over 25 mm or so"),
    "bow": Flaw("bow_radius_m", "m", 0.2, math.inf, "radius of sheet and page; inf: flat"),
    "bow-angle": Flaw("bow_angle_rad", "deg", -180, 180, "direction that is bent; 0: left to right", _PER_DEGREE),
    "corner": Flaw("corner_lift_mm", "mm", -20, 20, "the fourth corner off a table: a twisted page"),
    "glare": Flaw("glare", "share", 0, 0.5, "light of a lamp that the ribs mirror"),
    "side-light": Flaw("side_light", "share", -0.5, 0.5, "brighter on the right, darker on the left"),
}

#: What Mitsuba's scene has of a build, by option, or by field where there is none.
IN_MITSUBA = ("ink", "print-scale", "feed", "focus", "thickness", "lens-scale", "offset", "turn", "seed")
#: Builds by name, beyond how a hand puts sheet and page together (`Build.typical`), by option; "typical" has no flaw.
PRESETS: dict[str, dict[str, float]] = {
    "typical": {},
    "usual": {
        "ink": 42,
        "banding": 0.01,
        "focus": 1.07,
        "air": 0.05,
        "air-waves": 0.04,
        "wander": 0.02,
        "haze": 0.3,
        "bow": 1.5,
        "glare": 0.15,
        "side-light": 0.15,
    },
    "poor": {
        "ink": 64,
        "banding": 0.03,
        "focus": 1.27,
        "air": 0.15,
        "air-waves": 0.08,
        "wander": 0.05,
        "gradient": 0.003,
        "haze": 0.6,
        "bow": 0.7,
        "bow-angle": 20,
        "corner": 3,
        "glare": 0.3,
        "side-light": 0.3,
    },
}
BUILDS = ("ideal", *PRESETS)


def flaw_fields(wishes: dict[str, float]) -> dict[str, float]:
    """Values of the fields of `Build` for values of the options.

    Raises
    ------
    SpecError
        For a name that is none, or a value out of its range.
    """
    return {FLAWS[name].field: FLAWS[name].factor * value for name, value in wishes.items() if _in_range(name, value)}


def read_flaw(text: str) -> tuple[str, float]:
    """The name and value of NAME=VALUE.

    Raises
    ------
    SpecError
        For a name that is none, and for a value that is no number or out of its range.
    """
    name, _, value = text.partition("=")
    try:
        number = float(value)
    except ValueError:
        raise SpecError(f"flaw {text!r} has no number; give NAME=VALUE, such as air=0.05") from None
    _in_range(name, number)
    return name, number


def _in_range(name: str, value: float) -> bool:
    """True.  Raises: SpecError."""
    if name not in FLAWS:
        raise SpecError(f"flaw {name!r} is not known; choose one of {', '.join(FLAWS)}")
    one = FLAWS[name]
    if not one.low <= value <= one.high:
        raise SpecError(f"flaw {name}={value:g} is out of range; give {_range(one)}")
    return True


def _range(one: Flaw) -> str:
    unit = f" {one.unit}" if one.unit in ("um", "mm", "m", "deg") else ""
    return f"{one.low:g}{unit} or more" if one.high == math.inf else f"{one.low:g} to {one.high:g}{unit}"


def flaw_lines() -> list[str]:
    """Name, range with unit, and meaning of each flaw, a line each, for the command's help."""
    return [f"{name:<11}  {_range(one):<15}  {one.meaning}" for name, one in FLAWS.items()]
