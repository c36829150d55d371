"""All that a photograph or a film of a pitch test shows: the sheet's pitch, and the growth of lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.calibration.chart_reading import ChartView, check_chart, view_chart
from moireid.calibration.ink_reading import InkGrowth, ink_growth
from moireid.calibration.lens_fit import lens_from_views
from moireid.calibration.still import load_pictures
from moireid.errors import MediaError
from moireid.files import AnyPath, as_path
from moireid.profiles import LensProfile, PrinterProfile, find_dpi
from moireid.verifier.measuring import FOCAL_PRIOR_RATIO

#: Standard deviation of the camera's distance as a share, by where it comes from: a tape measure, a focal length that
#: was calibrated, one that the camera noted (rounded, and cropped by stabilisation), and that of a usual phone.
DISTANCE_SD = {"a tape measure": 0.03, "the focal length": 0.02, "the camera's note": 0.06, "a usual phone": 0.35}


@dataclass(frozen=True)
class SheetReading:
    """What pictures of a pitch test show.

    Attributes
    ----------
    profile : LensProfile
        Of the sheet.
    ink : InkGrowth
        By how much the printer widens lines.
    """

    profile: LensProfile
    ink: InkGrowth


def read_sheet(
    path: AnyPath,
    chart: Badge,
    distance_m: float | None = None,
    focal_px: float | None = None,
    measured_scale: float | None = None,
    *,
    progress: Callable[[int, int | None], None] | None = None,
) -> SheetReading:
    """Read a photograph or a film of the pitch test, with the best known distance of the camera.

    Parameters
    ----------
    path : str or Path
        The photograph or film.
    chart : Badge
        The pitch test sheet.
    distance_m : float, optional
        From the camera to the sheet, m.
    focal_px : float, optional
        Focal length of the picture, px.
    measured_scale : float, optional
        As for `lens_from_views`.
    progress : callable, optional
        Called with the number of pictures that were read, and of all.

    Raises
    ------
    SpecError
        Where the badge is no pitch test sheet, or the distance contradicts the picture.
    MediaError
        Where the file cannot be read or does not show this chart under a sheet.
    """
    check_chart(chart)
    path = as_path(path)
    pictures, noted_px = load_pictures(path)
    known = {"a tape measure": distance_m, "the focal length": focal_px, "the camera's note": noted_px}
    source = next((name for name, value in known.items() if value), "a usual phone")
    focal = focal_px or noted_px or FOCAL_PRIOR_RATIO * max(pictures[0].shape)
    seen = _views(pictures, chart, focal, 1000 * distance_m if distance_m else None, progress)
    profile = lens_from_views(
        [view for _, view in seen],
        chart,
        distance_sd_share=DISTANCE_SD[source],
        distance_from=source,
        measured_scale=measured_scale,
    )
    ink = ink_growth([(picture, view.page) for picture, view in seen if view.page is not None], chart)
    return SheetReading(profile, ink)


def _views(
    pictures: list[NDArray[np.uint8]],
    chart: Badge,
    focal_px: float,
    distance_mm: float | None,
    progress: Callable[[int, int | None], None] | None,
) -> list[tuple[NDArray[np.uint8], ChartView]]:
    """Those pictures that show the chart, with what they show; if none does, raises the error of the first."""
    found: list[tuple[NDArray[np.uint8], ChartView]] = []
    first: MediaError | None = None
    for number, picture in enumerate(pictures, start=1):
        try:
            found.append((picture, view_chart(picture, chart, focal_px=focal_px, distance_mm=distance_mm)))
        except MediaError as wrong:
            first = first or wrong
        if progress is not None:
            progress(number, len(pictures))
    if not found and first is not None:
        raise first
    return found


def printer_profile(chart: Badge, ink: InkGrowth, measured_scale: tuple[float, float] | None = None) -> PrinterProfile:
    """The profile of the printer that printed a chart.

    Parameters: measured_scale: measured over stated length of the scale bars along x and y, None if not measured.
    """
    noted = {"chart": chart.name, "pictures": ink.pictures, "misfit": round(ink.misfit, 4)}
    noted |= {"why_no_ink_growth": ink.why} if ink.um is None else {}
    dpi = find_dpi(chart)
    sd_um = None if ink.um is None else ink.sd_um
    return PrinterProfile(f"printer of {dpi} dpi", dpi, ink.um, sd_um, measured_scale, noted)
