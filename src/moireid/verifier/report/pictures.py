"""The pictures of a report, drawn where the film is, as files by their names."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import cv2

from moireid.verifier.report.frame import frame_picture, telling_moment
from moireid.verifier.report.law_plot import NARROW, law_plot
from moireid.verifier.report.plots import plots_of
from moireid.verifier.report.rival_plot import rival_plot
from moireid.verifier.session.result import Report

LAW, LAW_NARROW, BADGE, FRAME = "law.svg", "law-narrow.svg", "badge.png", "frame.jpg"
RIVAL, RIVAL_NARROW = "rival.svg", "rival-narrow.svg"
#: The names that pictures can have, and nothing else.
NAME = re.compile(r"(?:law|rival)(?:-narrow)?\.svg|plot[0-9]{1,2}\.svg|badge\.png|frame\.jpg")
KINDS = {"svg": "image/svg+xml", "png": "image/png", "jpg": "image/jpeg"}


@dataclass(frozen=True)
class Pictures:
    """Contents by name, titles of the plots for experts in the order of their numbers, and the frame's time, s."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    plots: tuple[str, ...] = ()
    frame_s: float | None = None


def pictures_of(report: Report) -> Pictures:
    """Draw the pictures of a report, in about a second."""
    files: dict[str, bytes] = {}
    plots = plots_of(report)
    drawn = {LAW: law_plot(report), LAW_NARROW: law_plot(report, NARROW)}
    drawn |= {RIVAL: rival_plot(report), RIVAL_NARROW: rival_plot(report, NARROW)}
    files |= {name: svg.encode() for name, svg in drawn.items() if svg is not None}
    files |= {f"plot{number}.svg": svg.encode() for number, (_, svg) in enumerate(plots)}
    if report.track.snapshot is not None:
        files[BADGE] = cv2.imencode(".png", report.track.snapshot)[1].tobytes()
    moment = telling_moment(report)
    if (shown := frame_picture(report, moment)) is not None:
        files[FRAME] = shown
    return Pictures(files, tuple(title for title, _ in plots), moment.time_s)
