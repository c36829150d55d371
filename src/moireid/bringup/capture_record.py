"""The capture record: films of a badge that somebody built, as signals and crops, to be compared with the prediction.

One JSON file.  Of each film it holds what its report says in figures (`Report.to_json`: verdict, findings, invariant,
explanations, camera, frames), its signals.csv, its as-built figures, and crops of the fringe fields as PNG in base64.

What it holds of people: no name, no identity and no badge.json unless they are asked for, no path, no date, no sound,
and of the pictures the fringe fields alone.  But the fringes spell the badge's code: who has the record can read its
identity from the crops, and has the figures that distinguish this badge from a copy.
"""

from __future__ import annotations

import base64
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

import cv2
import msgspec

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.bringup.build_folder import Figure
from moireid.bringup.field_crops import FieldCrop
from moireid.files import AnyPath, write_text
from moireid.profiles import LensProfile, PrinterProfile, profile_document
from moireid.verifier.session.result import Report
from moireid.version import __version__

FORMAT, NOTE_CHARACTERS = 1, 2000
#: Packages whose versions may change a measurement.
PACKAGES = ("numpy", "scipy", "opencv-contrib-python-headless", "av")
#: What a film's report says without words.
FROM_REPORT = ("verdict", "invariant", "explanations", "camera", "frames")


def film_record(report: Report, built: AsBuilt | None, crops: Sequence[FieldCrop]) -> dict[str, Any]:
    """One film: without its path, its sentences and its id."""
    document = report.to_json()
    findings = [{key: value for key, value in one.items() if key != "text"} for one in document["reasons"]]
    for one in findings:
        # Words may hold a name.
        one |= {key: None for key in ("measured", "limit") if isinstance(one[key], str)}
    return {key: document[key] for key in FROM_REPORT} | {
        "findings": findings,
        "picture_px": list(report.track.image_px),
        "signals_csv": report.signals().to_csv(),
        "as_built": built and {key: value for key, value in asdict(built).items() if key != "badge_id"},
        "crops": [
            {
                "time_s": crop.time_s,
                "rect_mm": crop.rect_mm,
                "px_per_mm": crop.px_per_mm,
                "png": base64.b64encode(cv2.imencode(".png", crop.picture)[1].tobytes()).decode(),
            }
            for crop in crops
        ],
    }


def capture_record(
    films: Sequence[Mapping[str, Any]],
    badge: Badge,
    *,
    figures: Sequence[Figure],
    sheet: LensProfile,
    printer: PrinterProfile,
    with_badge: bool,
    note: str,
) -> dict[str, Any]:
    """The record of some films.

    Parameters
    ----------
    films : sequence of mapping
        As `film_record` gives them.
    figures : sequence of Figure
        What `first-badge` found.
    with_badge : bool
        Whether badge.json goes with it, which has name and identity.
    note : str
        Words of the builder, such as where the sheet was bought.
    """
    made_by = {"moireid": __version__, "python": platform.python_version()}
    printed = {key: (badge.print or {}).get(key) for key in ("dpi", "paper", "form", "ink_growth_um")}
    return {
        "format": FORMAT,
        "kind": "moireid-capture-record",
        "made_by": made_by | {package: version(package) for package in PACKAGES},
        "lens": asdict(badge.lens),
        "print": printed,
        "films": films,
        "figures": msgspec.to_builtins(figures),
        "sheet": profile_document(sheet),
        "printer": profile_document(printer),
        "note": note,
    } | ({"badge": json.loads(badge.to_json())} if with_badge else {})


def write_record(record: Mapping[str, Any], path: AnyPath) -> None:
    """Write a record, whole or not at all."""
    write_text(path, json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
