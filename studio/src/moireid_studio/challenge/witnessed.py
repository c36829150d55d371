"""Enrolment by a live check: the figures of a badge that followed prompts drawn at random.

A drawn capture is enough to enroll figures of any badge.  Here a forger must draw in time, to prompts that no one
knew before; the figures say so (`AsBuilt.witnessed`).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from moireid.verifier.session.capture import figures_in
from moireid.verifier.session.chapters import Chapter, invariant_of


def witnessed_figures(chapters: Sequence[Chapter]) -> dict[str, Any] | None:
    """As-built figures, as JSON, from the chapters of a live check that was accepted and judged for an enrolment.

    Convention: the gain is that of all chapters, the rest of the one that is shown; None if no chapter kept its track.
    """
    shown = next((chapter for chapter in chapters if chapter.track and chapter.measurement), None)
    if shown is None or shown.track is None or shown.measurement is None:
        return None
    found = figures_in(shown.track, shown.measurement, invariant_of(chapters))
    document: dict[str, Any] = json.loads(replace(found, witnessed=True).to_json())
    return document
