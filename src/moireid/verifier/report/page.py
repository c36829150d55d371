"""The report for people: one self-contained page with plots, and the same figures as JSON beside it."""

from __future__ import annotations

import base64
import csv
import io
import json
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import cv2

from moireid.files import planned, write_text
from moireid.verifier.report.plots import parallax_of, plots_of, timeline_plot
from moireid.verifier.session.result import Report

WORDS = {
    "accept": "The fringes moved as only a real badge's do, and the badge is the one claimed.",
    "reject": "The claimed badge is not accepted; the lines that fail say why.",
    "inconclusive": "This film does not show enough to decide.",
}


#: What was checked, in plain words.
SAYS = "Checked were the badge's fringes, which must move with the badge as optics demand, and whose badge it is."
SAYS_NOT = (
    "Not checked were the face, the voice, the words and everything else in the film, or who wore the badge and when."
)


def words_of(verdict: str, invariant: str, identity: str, source: str | None = None) -> str:
    """A verdict in a sentence or two; invariant, identity: the verdicts on these two; source: of the claim.

    Convention: nobody vouches for a name in a file, so with a file a badge is accepted and never a person.
    """
    if verdict == "accept" and identity == "match" and source == "file":
        return "The film shows the badge of the file that was given. Nobody vouches for the name in that file."
    if verdict == "accept" and identity == "not_claimed":
        return "The fringes moved as only a real badge's do. No identity was claimed."
    if verdict == "reject" and invariant == "reject":
        return "The fringes did not move as a real badge's do, so this is no film of the real badge."
    if verdict == "reject" and invariant == "accept" and identity == "mismatch":
        return "The fringes moved as only a real badge's do, but it is not the badge that is claimed."
    return WORDS[verdict]


def holder_words(name: str, badge_id: str | None, source: str | None) -> str:
    """Whose badge is claimed, and on whose word."""
    if source == "bundle":
        return f"{name} ({badge_id or 'identity sealed in a bundle'})"
    if badge_id is None:
        return f"{name or 'unnamed board'} (no identity)"
    if source == "file":
        return f"badge {badge_id}, named {name!r} (from a file, not from a registry)"
    return f"{name} ({badge_id})"


def report_paths(folder: Path) -> list[Path]:
    """The files that `write_report` writes."""
    return [folder / "report.html", folder / "report.json", folder / "signals.csv"]


@dataclass(frozen=True)
class Pictures:
    """Titles and SVG texts of the plots, the timeline's SVG or None, and the rectified badge as PNG or None."""

    plots: tuple[tuple[str, str], ...]
    timeline: str | None
    badge_png: bytes | None


def pictures_of(report: Report) -> Pictures:
    """Draw the pictures of a report, in about a second."""
    png = None
    if report.track.snapshot is not None:
        png = cv2.imencode(".png", report.track.snapshot)[1].tobytes()
    return Pictures(tuple(plots_of(report)), timeline_plot(report), png)


def write_report(
    report: Report, folder: Path, *, overwrite: bool = False, pictures: Pictures | None = None
) -> list[Path]:
    """Write the page for people, the same as JSON, and the signals as CSV, each whole or not at all.

    Parameters
    ----------
    report : Report
        What `verify` found.
    folder : Path
        Made where it is absent.
    overwrite : bool
        Whether older files may be replaced.
    pictures : Pictures, optional
        As `pictures_of` draws them; None to draw them now.

    Returns
    -------
    list of Path
        report.html, report.json and signals.csv.

    Raises
    ------
    SpecError
        Where a file is in the way.
    """
    page, data, signals = report_paths(folder)
    planned([page, data, signals], overwrite=overwrite)
    write_text(page, render_page(report, pictures))
    write_text(data, json.dumps(report.to_json(), indent=1, ensure_ascii=False) + "\n")
    write_text(signals, signals_csv(report))
    return [page, data, signals]


def signals_csv(report: Report) -> str:
    """Time, camera and phases of the frames in the report's plots, one line each; only the header if there are none.

    Convention: parallax u = Cx / |Cz| at the page's middle, positive where the camera is at +x; phases in rad, mean 0.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    found = report.measurement
    count = len(report.badge.gratings)
    names = [f"{what}_{g}" for g in range(count) for what in ("measured_rad", "predicted_rad", "phase_sd_rad")]
    writer.writerow(
        ["frame", "time_s", "camera_x_mm", "camera_y_mm", "camera_z_mm", "parallax_x", "parallax_y", *names]
    )
    if found is None:
        return out.getvalue()
    parallax = parallax_of(report)
    for k, time_s in enumerate(found.times_s):
        phases = [
            value[k]
            for signal in found.gratings
            for value in (signal.measured_rad, signal.predicted_rad, signal.phase_sd_rad)
        ]
        figures = [f"{value:.6g}" for value in (time_s, *found.camera_mm[k], *parallax[k], *phases)]
        writer.writerow([int(report.track.frame_numbers[k]), *figures])
    return out.getvalue()


def render_page(report: Report, pictures: Pictures | None = None) -> str:
    """The report as one HTML page that needs no other file."""
    import jinja2

    shown = pictures or pictures_of(report)
    template = resources.files("moireid.verifier.report").joinpath("report.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    words = words_of(report.verdict, report.invariant.verdict, report.identity.verdict, report.claim_source)
    picture = "data:image/png;base64," + base64.b64encode(shown.badge_png).decode() if shown.badge_png else None
    return environment.from_string(template).render(
        report=report,
        data=report.to_json(),
        words=words,
        holder=holder_words(report.badge.name, report.identity.claimed_id, report.claim_source),
        plots=shown.plots,
        picture=picture,
        timeline=shown.timeline,
        says=SAYS,
        says_not=SAYS_NOT,
    )
