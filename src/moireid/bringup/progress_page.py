"""The report of a first badge: what comes next, all figures with error bars, and what was seen; one file."""

from __future__ import annotations

import base64
import shlex
from importlib import resources

from moireid.bringup.badge_steps import AS_BUILT
from moireid.bringup.bring_up import Advance
from moireid.bringup.build_folder import BADGE_JSON, BuildFolder, Figure
from moireid.bringup.chart_steps import CAMERA, PRINTER, SHEET
from moireid.verifier.report.report_page import KINDS, style
from moireid.version import __version__

PAGE = "report.html"
STATES = {"good": "good", "look": "look at it", "unknown": "not known"}
#: What the profiles are for.
PROFILES = {
    SHEET: "the lens sheet: print-your-badge --lens {}",
    PRINTER: "the printer: print-your-badge --printer {}",
    CAMERA: "the camera: moireid verify --camera {}",
    AS_BUILT: "the badge as it was built; moireid enroll --capture measures the same",
    BADGE_JSON: "the badge: keep it, it is the only copy",
}


def shown_value(figure: Figure) -> str:
    """The value with its error bar, rounded to two digits of it."""
    if figure.value is None:
        return "not known"
    if figure.sd is None or figure.sd <= 0:
        return f"{figure.value:.3g} {figure.unit}"
    digits = max(0, 1 - _decade(figure.sd))
    return f"{figure.value:.{digits}f} ± {figure.sd:.{digits}f} {figure.unit}"


def _decade(value: float) -> int:
    """The power of ten of a value's first digit."""
    return int(f"{value:e}".split("e")[1])


def render_progress(advance: Advance) -> str:
    """The page, with its pictures in it."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    text = resources.files("moireid.bringup").joinpath("progress.html.j2").read_text(encoding="utf-8")
    folder = advance.folder
    return environment.from_string(text).render(
        style=style(),
        advance=advance,
        steps=[(step, step_state(advance, step.name)) for step in advance.steps],
        readings=[(step, folder.reading(step.name)) for step in advance.steps],
        states=STATES,
        shown_value=shown_value,
        source=lambda name: _source(folder, name),
        files=[
            (name, words.format(shlex.quote(str(folder.at(name)))))
            for name, words in PROFILES.items()
            if folder.at(name).exists()
        ],
        version=__version__,
    )


def step_state(advance: Advance, name: str) -> str:
    """Of a step: done, next, not usable, left out or to come."""
    if advance.next_step is not None and advance.next_step.name == name:
        return "next"
    reading = advance.folder.reading(name)
    if reading is not None:
        return "not usable" if reading.refused else "done"
    names = [step.name for step in advance.steps]
    later = advance.next_step is not None and names.index(name) > names.index(advance.next_step.name)
    return "to come" if later else "left out"


def _source(folder: BuildFolder, name: str) -> str | None:
    """A picture as a data address; None where it is gone."""
    if not folder.at(name).is_file():
        return None
    kind = KINDS[name.rpartition(".")[2]]
    return f"data:{kind};base64," + base64.b64encode(folder.at(name).read_bytes()).decode()
