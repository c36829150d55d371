"""The report for people: one self-contained page, its pictures, and files with the same figures (JSON, CSV).

A page is made from a report's JSON, its pictures, and the circumstances of the check; the film is not needed.  So the
studio makes it outside the process that decoded the film.  The pictures are drawn in the process that has the film, as
files with fixed names.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
from msgspec import Meta

from moireid.files import AnyPath, as_path, planned, write_text
from moireid.verifier.report.circumstances import Circumstances, claimed_in, moment_words
from moireid.verifier.report.finding_words import sorted_findings
from moireid.verifier.report.headline import headline_of
from moireid.verifier.report.live_receipt import receipt_of
from moireid.verifier.report.rival_table import NO_PROBABILITY, table_of
from moireid.verifier.report.seconds import seconds_of
from moireid.version import __version__

if TYPE_CHECKING:
    from moireid.verifier.session.result import Report

LAW, LAW_NARROW, BADGE, FRAME = "law.svg", "law-narrow.svg", "badge.png", "frame.jpg"
#: The only names that pictures can have.
NAME = re.compile(r"law(?:-narrow)?\.svg|badge\.png|frame\.jpg")
KINDS = {"svg": "image/svg+xml", "png": "image/png", "jpg": "image/jpeg"}


class Pictures(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Contents by name, the frame's time, s, and the signals as CSV."""

    files: dict[Annotated[str, Meta(pattern=rf"^(?:{NAME.pattern})\Z")], bytes] = {}
    frame_s: float | None = None
    signals: str = ""


def pictures_of(report: Report) -> Pictures:
    """Draw the pictures of a report, in about a second."""
    # A page is shown from them without what draws them.
    import cv2

    from moireid.verifier.report.film_frame import frame_picture, moment_to_show
    from moireid.verifier.report.plots import NARROW, law_plot

    drawn = {LAW: law_plot(report), LAW_NARROW: law_plot(report, NARROW)}
    files = {name: svg.encode() for name, svg in drawn.items() if svg is not None}
    if report.track.snapshot is not None:
        files[BADGE] = cv2.imencode(".png", report.track.snapshot)[1].tobytes()
    moment = moment_to_show(report)
    if (shown := frame_picture(report, moment)) is not None:
        files[FRAME] = shown
    return Pictures(files, moment[1], report.signals().to_csv())


#: What was checked, in plain words.
SAYS = "Checked were the badge's fringes, which must move with the badge as optics demand, and whose badge it is."
SAYS_NOT = (
    "Not checked were the face, the voice, the words and everything else in the film, nor who wore the badge and when. "
    'A film that was computed, or mapped from a film of another badge, can pass: "What it takes to pass", in '
    "moireid's THREATS.md, lists what meets which forger."
)


def report_paths(folder: AnyPath) -> list[Path]:
    """The files that `write_report` writes."""
    folder = as_path(folder)
    return [folder / "report.html", folder / "report.json", folder / "signals.csv"]


def write_report(
    report: Report,
    folder: AnyPath,
    *,
    overwrite: bool = False,
    pictures: Pictures | None = None,
    known: Circumstances | None = None,
) -> list[Path]:
    """Write the page for people, the same as JSON, and the signals as CSV, each whole or not at all.

    Parameters
    ----------
    report : Report
        What `verify` found.
    folder : str or Path
        Made if it does not exist.
    overwrite : bool
        Whether older files may be replaced.
    pictures : Pictures, optional
        As `pictures_of` draws them; None to draw them now, one of them from the film itself.
    known : Circumstances, optional
        How the check was made, and what a registry says; None for a check made just now without a registry.

    Returns
    -------
    list of Path
        report.html, report.json and signals.csv.

    Raises
    ------
    SpecError
        If a file would be replaced.
    """
    shown, known = pictures or pictures_of(report), known or Circumstances(datetime.now(UTC))
    return write_pages(report.to_json(), shown, known, folder, overwrite=overwrite)


def write_pages(
    document: Mapping[str, Any],
    pictures: Pictures,
    known: Circumstances,
    folder: AnyPath,
    *,
    overwrite: bool,
) -> list[Path]:
    """Write the files of `write_report` from a report's JSON, its pictures and its signals; of the film its name alone,
    as reports are published.
    """
    paths = report_paths(folder)
    planned(paths, overwrite=overwrite)
    if "path" in (film := document.get("input") or {}):
        document = {**document, "input": film | {"path": known.film_name or Path(film["path"]).name}}
    shown = json.dumps(document, indent=1, ensure_ascii=False) + "\n"
    for path, text in zip(paths, (render_page(document, pictures, known), shown, pictures.signals), strict=True):
        write_text(path, text)
    return paths


def page_context(
    document: Mapping[str, Any], pictures: Pictures, known: Circumstances, source: Callable[[str], str]
) -> dict[str, Any]:
    """The variables of a page's template.

    Parameters: document: what `verify --json` or `identify --json` prints; source: the address of a picture, by name.
    """
    return {
        "data": document,
        "headline": headline_of(document, known),
        "findings": sorted_findings(document["reasons"]),
        "seconds": seconds_of(document),
        "table": table_of(document),
        "no_probability": NO_PROBABILITY,
        "claimed": claimed_in(document),
        "pictures": pictures,
        "source": source,
        "known": known,
        "live_checks": [receipt_of(one) for one in document.get("live_checks", ())],
        "checked": moment_words(known.checked_at),
        "made_by": document.get("moireid") or __version__,
        "film": known.film_name or Path((document.get("input") or {}).get("path", "")).name,
        "says": SAYS,
        "says_not": SAYS_NOT,
    }


def render_page(document: Mapping[str, Any], pictures: Pictures, known: Circumstances) -> str:
    """The report as one HTML page that needs no other file; parameters as `page_context`."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(template),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )

    def source(name: str) -> str:
        kind = KINDS[name.rpartition(".")[2]]
        return f"data:{kind};base64," + base64.b64encode(pictures.files[name]).decode()

    page = environment.get_template("report.html.j2")
    return page.render(style=style(), **page_context(document, pictures, known, source))


def template(name: str) -> str | None:
    """The text of one of this folder's templates, which the studio's pages use too; None if there is none."""
    found = resources.files("moireid.verifier.report").joinpath(name)
    return found.read_text(encoding="utf-8") if name.endswith(".html.j2") and found.is_file() else None


def style() -> str:
    """The style sheet that this page and the studio's page of a verdict share."""
    return resources.files("moireid.verifier.report").joinpath("report.css").read_text(encoding="utf-8")
