"""Steps with the badge: print it for the measured sheet and printer, and read two films of it."""

from __future__ import annotations

import filecmp
import json
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import msgspec

from moireid.asbuilt import AsBuilt, merge
from moireid.badge import Badge, load_badge
from moireid.bringup.build_folder import BADGE_FILMS, BADGE_JSON, CAMERA, BuildFolder, Figure, Reading
from moireid.bringup.chart_steps import PRINTER, SHEET, THICKNESS
from moireid.bringup.film_figures import film_figures
from moireid.errors import DesignError, MediaError
from moireid.files import write_text
from moireid.issuing import plan_badge
from moireid.profiles import load_lens_profile, load_printer_profile
from moireid.question import KnownCamera, Question
from moireid.reading.answers import checked
from moireid.reading.film_orders import Parts, Progress
from moireid.reading.film_reader import Readers, named
from moireid.verifier.camera.known_camera import load_camera
from moireid.verifier.session.capture import built_in, check_builds, why_refused
from moireid.verifier.session.film import verify
from moireid.verifier.session.known_figures import checked_figures
from moireid.verifier.session.result import Report

BADGE, AS_BUILT = "badge", "as-built.json"


def print_first_badge(folder: BuildFolder, *_: object) -> Reading:
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


def read_films(folder: BuildFolder, progress: Progress, readers: Readers) -> Reading:
    """Judge both films as an enrolment would, and say what they show of the badge."""
    badge = load_badge(folder.at(BADGE_JSON))
    camera = load_camera(folder.at(CAMERA)) if folder.at(CAMERA).exists() else None
    paths = [path for path in map(folder.found, BADGE_FILMS) if path is not None]
    if filecmp.cmp(paths[0], paths[1], shallow=False):
        raise MediaError(f"{paths[0]} and {paths[1]} are the same film; film the badge a second time")
    thickness = next((one for one in folder.figures() if one.name == THICKNESS), None)
    order = partial(measure_films, films=paths, badge=badge, camera=camera, thickness=thickness)
    with readers(paths) as reader:
        found = reader.read(order, progress).result
    reading = checked(found.get("reading"), Reading, named(paths))
    if reading.refused is None:
        write_text(folder.at(AS_BUILT), checked_figures(found.get("as_built"), badge).to_json() + "\n")
    return reading


def measure_films(
    progress: Progress, *, films: list[Path], badge: Badge, camera: KnownCamera | None, thickness: Figure | None
) -> Parts:
    """What two films show of a badge, for a sealed process: a `Reading`, and the as-built figures unless refused."""
    question = Question(badge, badge.id, camera=camera, enrolling=True)
    reports = [verify(path, question, progress=progress) for path in films]
    built = [one for one in map(built_in, reports) if one is not None]
    refused = _refused(reports, built, films, badge)
    reading = Reading(figures=film_figures(reports, built, badge, thickness), refused=refused)
    as_built = json.loads(merge(built).to_json()) if refused is None else None
    yield {"result": {"reading": msgspec.to_builtins(reading), "as_built": as_built}}


def _refused(reports: Sequence[Report], built: list[AsBuilt], paths: list[Path], badge: Badge) -> str | None:
    """Why the films cannot enroll the badge; None if they can."""
    for path, report in zip(paths, reports, strict=True):
        if built_in(report) is None:
            return f"{path.name} cannot be used: {why_refused(report)} Film the badge again, moving it sideways."
    try:
        check_builds(built, paths, badge)
    except MediaError as error:
        return str(error)
    return None
