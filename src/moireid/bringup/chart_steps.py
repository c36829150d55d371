"""Steps before there is a badge: print the pitch test, and read it."""

from __future__ import annotations

from functools import partial

import msgspec

from moireid.badge import load_badge
from moireid.bringup.build_folder import SHEET_PHOTO, BuildFolder, Figure, Reading
from moireid.calibration.film_orders import film_read
from moireid.calibration.sheet_reading import SheetReading, printer_profile, read_sheet
from moireid.fabrication.page.chart_page import JSON, PDF, print_chart
from moireid.profiles import save_profile
from moireid.reading.film_orders import Progress
from moireid.reading.film_reader import Readers
from moireid.sheets import MM_PER_INCH, sheet_lens

SHEET, PRINTER = "sheet.json", "printer.json"
THICKNESS = "Sheet thickness"
#: Errors of a calliper, mm, and of a ruler on a scale bar, as a share: 0.15 of 150 mm.  Set by hand.
CALLIPER_SD_MM, RULER_SD_SHARE = 0.01, 0.001
#: Below these, a pitch needs no better photo; a growth needs no care.  Share, um.  Set by hand.
GOOD_PITCH_SD_SHARE, GOOD_INK_SD_UM = 5e-4, 8.0


def print_charts(folder: BuildFolder, *_: object) -> Reading:
    """Write the pitch test."""
    from moireid.designer.chart import design_chart

    wish = folder.wish
    chart = design_chart(lens=wish.lens, printer_dpi=wish.printer_dpi, paper=wish.paper)
    print_chart(chart, folder.path, overwrite=True)
    return Reading()


def read_charts(folder: BuildFolder, progress: Progress, readers: Readers) -> Reading:
    """The sheet's pitch and the growth of lines from the photo; the thickness from a calliper."""
    wish, chart = folder.wish, load_badge(folder.at(JSON))
    photo, scales = folder.found(SHEET_PHOTO), wish.measured_scale
    assert photo is not None
    along = scales and scales[0]
    read = partial(read_sheet, chart=chart, distance_m=wish.distance_m, focal_px=wish.focal_px, measured_scale=along)
    with readers([photo]) as reader:
        found = film_read(photo, read, SheetReading, reader, progress)
    profile = found.profile
    if wish.thickness_mm is not None:
        lens = sheet_lens(profile.lens.pitch_mm, wish.thickness_mm, profile.lens.refractive_index)
        profile = msgspec.structs.replace(profile, lens=lens, found=profile.found | {"thickness_from": "a calliper"})
    save_profile(profile, folder.at(SHEET))
    save_profile(printer_profile(chart, found.ink, scales), folder.at(PRINTER))
    pitch, *others = sheet_figures(found, scales)
    return Reading(figures=[pitch, _thickness(wish.thickness_mm, profile.lens.thickness_mm), *others])


def sheet_figures(found: SheetReading, scales: tuple[float, float] | None) -> list[Figure]:
    """What a photograph of the pitch test shows: the sheet's pitch, the ink's spread, and the scale of the print.

    Parameters: scales: measured over stated length of the scale bars, None if not measured.
    """
    return [_pitch(found), _ink(found), _scale(scales)]


def _pitch(found: SheetReading) -> Figure:
    profile = found.profile
    good = profile.pitch_sd_mm < GOOD_PITCH_SD_SHARE * profile.lens.pitch_mm
    unit = "true mm" if profile.found["unit"] == "true mm" else "mm of the page"
    words = (
        f"{MM_PER_INCH / profile.lens.pitch_mm:.3f} lenses to the inch, from {profile.found['bands_used']} of "
        f"{profile.found['bands']} bands; the camera's distance is from {profile.found['distance_from']}."
    )
    advice = "" if good else "Give the camera's distance by a tape measure, or its focal length."
    return Figure("Sheet pitch", profile.lens.pitch_mm, profile.pitch_sd_mm, unit, words, advice)


def _thickness(calliper_mm: float | None, label_mm: float) -> Figure:
    if calliper_mm is None:
        words = f"Not measured: the label's {label_mm:.2f} mm is used."
        advice = "Measure it with a calliper, and give its thickness."
        return Figure(THICKNESS, None, None, "mm", words, advice)
    words = f"By a calliper; its error is taken to be {CALLIPER_SD_MM:g} mm."
    return Figure(THICKNESS, calliper_mm, CALLIPER_SD_MM, "mm", words)


def _ink(found: SheetReading) -> Figure:
    ink = found.ink
    if ink.um is None:
        return Figure("Ink spread", None, None, "um", f"Not measured: {ink.why}", "Photograph it again.")
    good = ink.sd_um < GOOD_INK_SD_UM
    words = (
        "How much wider than drawn the printer makes a line, with the shadow of ink within the paper; the "
        "badge is drawn with lines narrower by that."
    )
    advice = "" if good else "Photograph it again, sharp and in even light."
    return Figure("Ink spread", ink.um, ink.sd_um, "um", words, advice)


def _scale(scales: tuple[float, float] | None) -> Figure:
    if scales is None:
        words = "Not measured. Pitches are in mm of the printed page, which is right for this printer at this scale."
        advice = "For true mm, measure both scale bars with a ruler, and give the measured scale."
        return Figure("Print scale", None, None, "x", words, advice)
    words = f"By a ruler: {scales[0]:.4f} across, {scales[1]:.4f} down. The badge is drawn at the inverse."
    return Figure("Print scale", scales[0], RULER_SD_SHARE, "x", words)


#: Files that these steps write.
CHART_FILES = (PDF, JSON)
