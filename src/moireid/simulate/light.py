"""Where the light comes from, and the bands into which the lenses focus it on the page.

Light reaches the page through the same lenses through which the camera sees it.  So a lamp, a window or a soft box is
focused into one bright band under each lens, which is as wide as the light.  A line in the band is lit, a line next
to it is not.  Seen from other directions the badge is dark and its fringes change.  An even sky makes no such band.

A light here is a disc that faces the board's centre, together with an even sky.  It stays still in the board's frame.

Left out: light from the page to the lens and back (it lights the page nearly evenly).  Of the disc's changing direction
along the lenses only the change of brightness is included.

Convention: board frame of `motion`, mm; the light is in front of the badge, at negative z.  A perfectly white page
without a sheet over it, at the board's centre, would have radiance 1, the scale of `scene.ink` and `scene.paper`.
Source: the forward trace is `lenticule.trace_mm`, Snell's law; Fresnel's equations for unpolarised light.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Lens
from moireid.errors import SpecError
from moireid.frames import OwnFrame
from moireid.lenticule import trace_mm
from moireid.optics import passed_share, slab_shift_mm

Array = NDArray[np.float64]
#: The light on the page is kept at this many places across one lens pitch: every 2 um for 0.5 mm.
BINS = 256
#: Rays traced across one lens, and points of the light across the lenses and along them.
RAYS, ACROSS, ALONG = 1024, 33, 5
#: A light must be farther from the badge than this, mm.
NEAREST_MM = 50.0
#: Rows of the table for lights near by: the light moves by this share of its radius from one to the next.
ROW_SHARE, MOST_ROWS = 0.125, 65


@dataclass(frozen=True)
class DiscLight:
    """A disc of light before an even sky.

    Parameters
    ----------
    place_mm : (float, float, float)
        The disc's middle in the board frame, mm; z is negative, as the light is in front of the badge.
    radius_mm : float
        Of the disc, mm.
    share : float
        Of the light on the page that comes from the disc, 0 to 1; 0 for an even sky alone.

    Raises
    ------
    SpecError
        Where that is no light in front of the badge.

    Notes
    -----
    Convention: a white page without a sheet over it, at the board's centre, has radiance 1.
    Source: Snell's law and Fresnel's equations for unpolarised light; see `moireid.lenticule.trace_mm`.
    """

    place_mm: tuple[float, float, float] = (0.0, 0.0, -1000.0)
    radius_mm: float = 100.0
    share: float = 0.0

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (*self.place_mm, self.radius_mm, self.share))):
            raise SpecError(f"{self} is no light; give finite figures")
        if self.place_mm[2] > -NEAREST_MM or not 0 < self.radius_mm < -self.place_mm[2] or not 0 <= self.share <= 1:
            raise SpecError(
                f"{self} is no light in front of the badge; give place_mm with z of {-NEAREST_MM:g} mm or less, a "
                "radius_mm above 0 and less than its distance from the badge's plane, and a share of 0 to 1"
            )

    @property
    def half_angle_rad(self) -> float:
        """Angular radius of the disc, seen from the board's centre."""
        return math.atan2(self.radius_mm, math.dist((0, 0, 0), self.place_mm))

    @property
    def radiance(self) -> float:
        """Of the disc, on the scale of the module docstring.

        Source: a cone of half angle a about a direction at theta from the normal gives pi sin^2 a cos theta of its
            radiance, and a white page returns a pi-th.
        """
        distance = math.dist((0, 0, 0), self.place_mm)
        return self.share * distance / (-self.place_mm[2] * math.sin(self.half_angle_rad) ** 2)


#: Lights by name, the badge hanging upright at the height of the camera.
LIGHTS = {
    # An overcast sky all round.
    "even": DiscLight(),
    # A photographer's round soft box, 0.8 m across, 1.5 m away, 35 degrees to the left and 25 up.
    "softbox": DiscLight((-780.0, -634.0, -1114.0), 400.0, 0.7),
    # A window of about a square metre, 2.5 m away, 40 degrees to the right, at the badge's own height.
    "window": DiscLight((1607.0, 0.0, -1915.0), 560.0, 0.7),
    # A ceiling lamp, 0.25 m across, 2 m away, 45 degrees up and a little to the left.
    "lamp": DiscLight((-300.0, -1414.0, -1382.0), 125.0, 0.6),
    # The sun in a clear sky, half a degree across, 40 degrees up and 30 to the left; the sky gives the other fifth.
    "sun": DiscLight((-383_000.0, -643_000.0, -663_000.0), 4650.0, 0.8),
}


def light_named(name: str) -> DiscLight:
    """Give a light by name.

    Parameters
    ----------
    name : str
        One of `moireid.simulate.light.LIGHTS`: "even", "softbox", "window", "lamp" or "sun".

    Returns
    -------
    DiscLight
        The light in the board frame.

    Raises
    ------
    SpecError
        For a name that is none.

    Notes
    -----
    Convention: as `DiscLight`.
    Source: rooms as they are; each figure is explained at its name.
    """
    if name not in LIGHTS:
        raise SpecError(f"light {name!r} is not known; choose one of {', '.join(LIGHTS)}")
    return LIGHTS[name]


def ribs_lamp(share: float) -> DiscLight:
    """A lamp at the height of the badge, which upright ribs mirror to a camera in front, in a band across the badge.

    Parameters
    ----------
    share : float
        Of the light on the page that comes from the lamp, 0 to 1.

    Returns
    -------
    DiscLight
        12 cm across, 1.5 m away, 23 degrees to the left; the even sky gives the rest.

    Notes
    -----
    Source: a cylinder keeps a ray's direction along its axis; so each lens mirrors the lamp where line of sight and
    light are at equal angles to the ribs, and all these places form one band.
    """
    return DiscLight((-600.0, 40.0, -1400.0), 60.0, share)


def straight_share(refractive_index: float) -> float:
    """`passed_share` straight on.  Convention: the same.  Source: its limit, 4 n / (n + 1)^2."""
    return 4.0 * refractive_index / (refractive_index + 1.0) ** 2


def light_table(lens: Lens, light: DiscLight, reach_mm: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Brightness of the page under each place of a lens: by the sky, and by the disc at some places across the sheet.

    Parameters: lens: as built; light: its place as (across the lenses, along them, depth); reach_mm: the sheet's extent
        across.
    Convention: relative to the module's white page, divided by `straight_share`, so that paper under an even sky is
        about as bright as `scene.paper`.  Bin k is the page k bins to the right of any lens's axis, whichever lens the
        light came through.
    Returns: sky (BINS,); places across (rows,) mm, evenly spaced; disc (rows, BINS).
    Source: rays from the disc's points, and of a sky of even radiance, traced through one lens; their power is spread
        over the place where they land.
    """
    sky = (1.0 - light.share) * _sky_profile(lens)
    width_mm = max(light.radius_mm * ROW_SHARE, 1e-6 * math.dist((0, 0, 0), light.place_mm))
    rows = int(np.clip(math.ceil((reach_mm[1] - reach_mm[0]) / width_mm), 2, MOST_ROWS)) if light.share else 2
    places = np.linspace(*reach_mm, rows)
    if light.share == 0:
        return sky, places, np.zeros((rows, BINS))
    whole = _disc_power(light, 0.0, lens.thickness_mm)[2].sum()
    disc = []
    for place in places:
        tan_x, tan_y, power = _disc_power(light, place, lens.thickness_mm)
        disc.append(light.share * _profile(lens, tan_x, tan_y, power / whole))
    return sky, places, np.stack(disc)


def _disc_power(light: DiscLight, place_mm: float, thickness_mm: float) -> tuple[Array, Array, Array]:
    """Tangents at which the disc's points light a place of the apex plane, and the power of each point."""
    middle = np.array(light.place_mm)
    toward = middle / np.linalg.norm(middle)
    side = np.cross([0.0, 1.0, 0.0], toward)
    side /= np.linalg.norm(side)
    up = np.cross(toward, side)
    # Midpoints of even steps across the disc, and of even steps along each chord; each represents its own area.
    u = ((np.arange(ACROSS) + 0.5) / ACROSS * 2 - 1)[:, None]
    chord = np.sqrt(1 - u**2)
    v = chord * ((np.arange(ALONG) + 0.5) / ALONG * 2 - 1)
    points = middle + light.radius_mm * (u[..., None] * side + v[..., None] * up)
    way = np.array([place_mm, 0.0, -thickness_mm]) - points
    far = np.linalg.norm(way, axis=-1)
    power = chord * (way[..., 2] / far) * np.abs(way @ toward) / far**3
    return (way[..., 0] / way[..., 2]).ravel(), (way[..., 1] / way[..., 2]).ravel(), power.ravel()


def _sky_profile(lens: Lens) -> Array:
    """The light of an even sky of unit irradiance at each place of a pitch."""
    # Points of the unit disc of direction cosines, evenly spread: each brings the same irradiance.
    axis = (np.arange(48) + 0.5) / 48 * 2 - 1
    x, y = (part.ravel() for part in np.meshgrid(axis, axis))
    down = np.sqrt(np.maximum(1 - x**2 - y**2, 0.0))
    # Grazing light meets more lenses than are traced; the dropped rays carry 2 % of a sky's light.
    kept = down > 0.15
    count = np.count_nonzero(down > 0)
    return _profile(lens, x[kept] / down[kept], y[kept] / down[kept], np.full(np.count_nonzero(kept), 1.0 / count))


def _profile(lens: Lens, tan_x: Array, tan_y: Array, power: Array) -> Array:
    """Light on the page, (BINS,): its mean is the share of power that passes, relative to `straight_share`."""
    across = ((np.arange(RAYS) + 0.5) / RAYS - 0.5) * lens.pitch_mm
    if lens.kind == "mask":
        clear = lens.open_fraction or 0.0
        landed = across * clear + slab_shift_mm(lens.thickness_mm, lens.refractive_index, tan_x, tan_y)[:, None]
        cosine = np.broadcast_to((1.0 / np.sqrt(1 + tan_x**2 + tan_y**2))[:, None], landed.shape)
        power = power * clear
    else:
        landed, cosine = trace_mm(lens, across, tan_x[:, None], tan_y[:, None])
    brings = power[:, None] * passed_share(lens.refractive_index, cosine) / RAYS
    met = np.isfinite(landed)
    place = landed[met] / lens.pitch_mm * BINS
    low = np.floor(place)
    # Each ray is shared between the two nearest bins, which keeps its place.
    bins = np.bincount(low.astype(int) % BINS, brings[met] * (1 - place + low), BINS)
    bins += np.bincount((low.astype(int) + 1) % BINS, brings[met] * (place - low), BINS)
    return bins * BINS / straight_share(lens.refractive_index)


def turned_light(light: DiscLight, frame: OwnFrame, twist_rad: float, offset_mm: float) -> DiscLight:
    """The light in the frame of a twisted sheet over a grating of that frame: across its lenses, along them, in depth.

    Convention: twist from x towards y; across counts from the axis of lenticule 0.
    Source: rotation about the view axis.
    """
    x, y, z = light.place_mm
    across, along = frame.directions((x, y)).tolist()
    cosine, sine = math.cos(twist_rad), frame.handed * math.sin(twist_rad)
    return replace(light, place_mm=(across * cosine + along * sine - offset_mm, along * cosine - across * sine, z))
