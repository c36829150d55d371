"""Steps with the badge: print it for the measured sheet and printer, and read two films of it."""

from __future__ import annotations

import filecmp
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from moireid.asbuilt import merge
from moireid.badge import Badge, load_badge
from moireid.bringup.build_folder import BADGE_FILMS, BADGE_JSON, BuildFolder, Reading
from moireid.bringup.capture_record import capture_record, film_record
from moireid.bringup.chart_steps import CAMERA, PRINTER, SHEET
from moireid.bringup.field_crops import FieldCrop, field_crops
from moireid.bringup.film_figures import FilmResult, film_figures
from moireid.errors import DesignError, MediaError, SpecError
from moireid.files import write_text
from moireid.issuing import plan_badge
from moireid.models import parse_json
from moireid.profiles import load_lens_profile, load_printer_profile
from moireid.question import Question
from moireid.verifier.camera.known_camera import load_camera
from moireid.verifier.report.plots import law_plot
from moireid.verifier.session.capture import built_in, check_builds, why_refused
from moireid.verifier.session.film import verify
from moireid.verifier.video import Progress

BADGE, FILMS, AS_BUILT = "badge", "films.json", "as-built.json"
#: White between two crops in a picture, px.
RIM_PX = 8


def print_first_badge(folder: BuildFolder, _: Progress | None) -> Reading:
    """Print a badge for the sheet and the printer as they were measured."""
    from moireid.designer import Order
    from moireid.fabrication.package import print_badge

    wish, printer = folder.wish, load_printer_profile(folder.at(PRINTER))
    notes, growth_um = [], printer.drawn_growth_um
    order = Order(
        wish.name,
        lens=folder.at(SHEET),
        printer_dpi=printer.dpi,
        ink_growth_um=growth_um,
        paper=wish.paper,
        mount="none",
    )
    try:
        plan = plan_badge(order)
    except DesignError as error:
        if not growth_um:
            raise
        notes.append(f"The badge is drawn without regard to ink spread, as no lines so narrow can be drawn: {error}")
        plan = plan_badge(replace(order, ink_growth_um=0.0))
    print_badge(
        plan.badge,
        folder.at(BADGE),
        parts=plan.parts,
        measured_scale=printer.measured_scale or (1.0, 1.0),
        overwrite=True,
    )
    sheet = load_lens_profile(folder.at(SHEET))
    return Reading(notes=[*notes, *plan.notes, f"Printed for a sheet of {sheet.lens.pitch_mm:.5f} mm."])


def read_films(folder: BuildFolder, progress: Progress | None) -> Reading:
    """Judge both films as an enrolment would, and say what they show of the badge."""
    badge = load_badge(folder.at(BADGE_JSON))
    camera = load_camera(folder.at(CAMERA)) if folder.at(CAMERA).exists() else None
    paths = [path for path in map(folder.found, BADGE_FILMS) if path is not None]
    # A record never mixes films.
    folder.at(FILMS).unlink(missing_ok=True)
    if filecmp.cmp(paths[0], paths[1], shallow=False):
        raise MediaError(f"{paths[0]} and {paths[1]} are the same film; film the badge a second time")
    films, records, pictures = [], [], dict[str, str]()
    for number, path in enumerate(paths, 1):
        report = verify(path, Question(badge, badge.id, camera=camera, enrolling=True), progress=progress)
        found = FilmResult(path.name, report, built_in(report))
        films.append(found)
        crops = field_crops(report)
        records.append(film_record(report, found.built, crops))
        pictures |= _film_pictures(folder, number, found, crops)
    refused = _refused(films, paths, badge)
    thickness = next((one for one in folder.figures() if one.name == "Sheet thickness"), None)
    figures = film_figures(films, badge, thickness)
    write_text(folder.at(FILMS), json.dumps(records, allow_nan=False))
    built = [film.built for film in films if film.built is not None]
    if built and refused is None:
        write_text(folder.at(AS_BUILT), merge(built).to_json() + "\n")
    return Reading(figures=figures, pictures=pictures, refused=refused)


def _refused(films: Sequence[FilmResult], paths: list[Path], badge: Badge) -> str | None:
    """Why the films cannot enroll the badge; None if they can."""
    for film in films:
        if film.built is None:
            return f"{film.name} cannot be used: {why_refused(film.report)} Film the badge again, moving it sideways."
    try:
        check_builds([film.built for film in films if film.built is not None], paths, badge)
    except MediaError as error:
        return str(error)
    return None


def _film_pictures(folder: BuildFolder, number: int, found: FilmResult, crops: Sequence[FieldCrop]) -> dict[str, str]:
    """The law over time, and the badge's fringes in some frames side by side."""
    made = {}
    if (svg := law_plot(found.report)) is not None:
        name = f"law-{number}.svg"
        write_text(folder.at(name), svg)
        made[name] = f"Film {number}: where the fringes should be by the law, and where they were."
    if crops:
        name = f"fringes-{number}.jpg"
        blank = np.full((crops[0].picture.shape[0], RIM_PX), 255, np.uint8)
        strip = cv2.hconcat([part for crop in crops for part in (crop.picture, blank)][:-1])
        folder.save_picture(name, np.asarray(strip, np.uint8))
        made[name] = f"Film {number}: the fringes from one side to the other."
    return made


def collect_record(folder: BuildFolder, *, with_badge: bool, note: str) -> dict[str, Any]:
    """The capture record of a folder whose films were read.

    Raises: SpecError where they were not, or what was read of them is damaged.
    """
    if not folder.at(FILMS).exists():
        raise SpecError(f"{folder.path} has no films of a badge yet; do the steps of moireid first-badge first")
    text = folder.at(FILMS).read_bytes().decode("utf-8", "replace")
    return capture_record(
        parse_json(text, str(folder.at(FILMS)), "delete it, and the films are read again"),
        load_badge(folder.at(BADGE_JSON)),
        figures=folder.figures(),
        sheet=load_lens_profile(folder.at(SHEET)),
        printer=load_printer_profile(folder.at(PRINTER)),
        with_badge=with_badge,
        note=note,
    )
