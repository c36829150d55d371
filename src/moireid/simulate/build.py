"""How a built badge differs from its design, with builds by name."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from moireid.badge import Lens
from moireid.errors import SpecError
from moireid.sheets import sheet_lens
from moireid.simulate.flaw_table import BUILDS, FLAWS, PRESETS, flaw_fields


@dataclass(frozen=True)
class Build:
    """How the built badge differs from its design: sheet, print, how both are put together, and the light on it.

    Parameters
    ----------
    lens_offset_mm : float
        How far each sheet is moved along its fringes' axis, mm; positive for +x on an "x" grating.
    twist_rad : float
        How far each sheet is turned about the view axis, rad; positive from x towards y.
    print_scale : float
        Printed over nominal width, about the board's centre.
    lens_scale : float
        Real over nominal pitch of the sheet, about the board's centre.
    thickness_ratio : float
        Real over nominal thickness of the sheet; the lenses focus on its back again, as far as their pitch lets them.
    air_gap_mm : float
        Air between sheet and page, mm.
    bow_radius_m : float
        Radius to which sheet and page are bent together, m; the edges lie farther from the camera.
    pitch_jitter : float
        Standard deviation of each lens's width, as a share of the pitch; widths are independent.
    print_aspect : float
        Printed height over printed width, over that of the design; the width is `print_scale`'s.
    ink_um : float
        By how much printed lines are wider than designed, both edges together, um; of a badge that is drawn narrower
        for its printer (`print["ink_growth_um"]`), what that leaves.
    banding : float
        Amplitude of the page's reflectance, as a share, in bands that recur every `BAND_MM` along its height.
    focus_ratio : float
        Radius of the lenses at their tops, over the one that focuses on the sheet's back.
    conic : float
        Conic constant k of the lenses: a place x across is at the depth d of x^2 = 2 R d - (1 + k) d^2; 0 for a
        circle.  At -1/n^2 light from straight ahead meets in one point (Descartes).
    air_wave_mm : float
        Root mean square by which the air between sheet and page changes, smoothly over `SMOOTH_MM`, mm; where there
        would be less than none, the sheet touches the page.
    wander_mm : float
        Root mean square by which lenses are off their places, smoothly over `SMOOTH_MM`, mm, apart from an even
        stretch.
    pitch_gradient : float
        Change of the lens pitch from the low to the high edge of a grating's sheet, as a share.
    haze : float
        Share of the light that comes from all around, within some `HAZE_MM`, as it is scattered in the sheet.
    bow_angle_rad : float
        Direction along which sheet and page are bent, rad, from x towards y.
    corner_lift_mm : float
        By how much the lower right corner is off a table that the three others touch, mm, as sheet and page are
        twisted; negative where it would be below.  A length, because people can measure it with a ruler.
    glare : float
        Share of the light that comes from a lamp at the camera's height, which the ribs mirror (`light.ribs_lamp`).
        A scene that has a light of its own ignores it.
    side_light : float
        The page is brighter by this share at its right edge than in its middle, and darker at its left.
    seed : int
        Of what chance decides of bands, air, and the places of lenses; the same badge is alike in all its films.
    """

    lens_offset_mm: float = 0.0
    twist_rad: float = 0.0
    print_scale: float = 1.0
    lens_scale: float = 1.0
    thickness_ratio: float = 1.0
    air_gap_mm: float = 0.0
    bow_radius_m: float = math.inf
    pitch_jitter: float = 0.0
    print_aspect: float = 1.0
    ink_um: float = 0.0
    banding: float = 0.0
    focus_ratio: float = 1.0
    conic: float = 0.0
    air_wave_mm: float = 0.0
    wander_mm: float = 0.0
    pitch_gradient: float = 0.0
    haze: float = 0.0
    bow_angle_rad: float = 0.0
    corner_lift_mm: float = 0.0
    glare: float = 0.0
    side_light: float = 0.0
    seed: int = 0

    def lens_of(self, nominal: Lens) -> Lens:
        """The lens sheet of its thickness and lens radius as built, at its nominal pitch.

        Raises
        ------
        SpecError
            Where no sheet has that thickness, or lenses of that radius do not meet.
        """
        lens = nominal
        if self.thickness_ratio != 1.0:
            thickness_mm = self.thickness_ratio * nominal.thickness_mm
            if nominal.kind == "mask":
                return replace(nominal, thickness_mm=thickness_mm)
            lens = sheet_lens(nominal.pitch_mm, thickness_mm, nominal.refractive_index)
        if self.focus_ratio == 1.0 or lens.radius_mm is None:
            return lens
        return replace(lens, radius_mm=self.focus_ratio * lens.radius_mm)

    @property
    def is_bent(self) -> bool:
        """Whether sheet and page are not flat."""
        return math.isfinite(self.bow_radius_m) or self.corner_lift_mm != 0

    @property
    def is_uneven(self) -> bool:
        """Whether air or the lenses' places change over the sheet."""
        return bool(self.air_wave_mm or self.wander_mm or self.pitch_gradient or self.pitch_jitter)

    @property
    def differences(self) -> list[str]:
        """Fields that are not as designed."""
        return [one.name for one in fields(self) if getattr(self, one.name) != one.default]

    @property
    def print_scales(self) -> tuple[float, float]:
        """Printed over nominal size along the page's x and y, about the board's centre.

        Notes
        -----
        Convention: both belong to the page; a twist turns the sheet alone.
        """
        return self.print_scale, self.print_scale * self.print_aspect

    @staticmethod
    def typical(seed: int) -> Build:
        """One badge out of many.

        Parameters
        ----------
        seed : int
            Of what chance decides.

        Returns
        -------
        Build
            With a random offset within +-0.25 mm, and normal twist (standard deviation 0.1 degrees, at most 0.3),
            print scale (0.2 %, at most 0.5 % off), lens scale and print aspect (0.1 %, at most 0.3 % off).
        """
        rng = np.random.default_rng(seed)
        return Build(
            lens_offset_mm=float(rng.uniform(-0.25, 0.25)),
            twist_rad=math.radians(float(np.clip(rng.normal(0, 0.1), -0.3, 0.3))),
            print_scale=1 + float(np.clip(rng.normal(0, 0.002), -0.005, 0.005)),
            lens_scale=1 + float(np.clip(rng.normal(0, 0.001), -0.003, 0.003)),
            # Drawn last, so that a seed keeps what it drew before.
            print_aspect=1 + float(np.clip(rng.normal(0, 0.001), -0.003, 0.003)),
            seed=seed,
        )


BUILD_NUMBERS = tuple(one.name for one in fields(Build))
#: Set by hand, mm: bands recur after this, as turns of a gear do; air and lenses change over about this far (to a
#: correlation of 1/e); and light scatters in a sheet about this far.
BAND_MM, SMOOTH_MM, HAZE_MM = 12.7, 25.0, 3.0


def build_named(text: str, seed: int) -> Build:
    """A build by name.

    Parameters
    ----------
    text : str
        NAME or NAME:SEED, with a name of `flaw_table.BUILDS`.
    seed : int
        Of all that chance decides, where the text has none.

    Returns
    -------
    Build
        As designed for "ideal"; else `Build.typical` of the seed, with the flaws of `flaw_table.PRESETS`.

    Raises
    ------
    SpecError
        For a name that is none, or a seed that is no whole number.
    """
    name, colon, number = text.partition(":")
    if name not in BUILDS or (colon and not (number.isascii() and number.isdigit() and len(number) <= 10)):
        raise SpecError(
            f"build {text!r} is not known; give {', '.join(BUILDS)}, or one of them with a seed such as usual:7"
        )
    return Build() if name == "ideal" else flawed(Build.typical(int(number) if colon else seed), PRESETS[name])


def flawed(build: Build, wishes: dict[str, float]) -> Build:
    """The build with some of its quantities in place of its own.

    Parameters
    ----------
    build : Build
        The rest.
    wishes : dict of str to float
        Values by the names of `flaw_table.FLAWS`, in their units.

    Returns
    -------
    Build
        A new one.

    Raises
    ------
    SpecError
        For a name that is none, or a value out of its range.
    """
    return replace(build, **flaw_fields(wishes))  # type: ignore[arg-type]


def flaw_name(field: str) -> str:
    """The option's name for a field of `Build`, or the field's own."""
    return next((name for name, one in FLAWS.items() if one.field == field), field)
