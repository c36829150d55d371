"""The Enroll pages: a film of a finished badge, what was measured of it, and keeping that.

`measured_words` gives the figures of a capture in words.

Convention: as `AsBuilt`; each figure with two standard deviations, and the range in which a badge of this design works.
Source: a sheet that is d to the right turns the phase by 2 pi d / p_f; the phase is that of the light, and a dark line
lies in the middle of a grating, which is half a turn.  A sheet that is turned by a, clockwise, makes the phase run by
-2 pi a / p_f along the lenses.  The beat's range is what print scale and lens pitch may be off by
(`designer.reach.PITCH_TOLERANCE`), the twist's what a mount keeps to (`fabrication.process_figures.TWIST_DEG`), the
gain's what the verifier lets pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Form, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import RedirectResponse, Response

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.designer.reach import PITCH_TOLERANCE
from moireid.errors import MoireIdError
from moireid.fabrication.process_figures import TWIST_DEG
from moireid.registry import Record
from moireid.verifier.limits import ENROLLED_GAINS
from moireid.verifier.session.known_figures import CaptureComparison
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.checks import received
from moireid_studio.issue_jobs import as_built_of, compared_of, keep, start_capture
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.studio import studio_of

SD = 2.0


@dataclass(frozen=True)
class FigureRow:
    """One figure: whether it is within the range in which a badge of this design works, and its sentence, with two
    standard deviations."""

    label: str
    within: bool
    text: str


def measured_words(found: AsBuilt, badge: Badge) -> list[FigureRow]:
    """Beat, gain, twist and offset of one built badge; those that show faults best come first.

    Convention and source: module docstring.
    """
    pitch_mm = badge.lens.pitch_mm
    grating = next(grating for grating in badge.gratings if grating.code)
    assert grating.code is not None
    designed = abs(1 / grating.cells[grating.code.reference_cell].pitch_mm - 1 / pitch_mm)
    beat, beat_error = found.beat_period_mm, SD * found.beat_frequency_sd * found.beat_period_mm**2
    to_mm, to_deg = pitch_mm / (2 * math.pi), math.degrees(pitch_mm / (2 * math.pi))
    offset, offset_error = math.remainder(found.offset_rad + math.pi, 2 * math.pi) * to_mm, SD * found.offset_sd * to_mm
    twist, twist_error = -found.twist_rad_per_mm * to_deg, SD * found.twist_sd * to_deg
    ways = ("right", "left") if grating.axis == "x" else ("lower side", "upper side")
    low, high = ENROLLED_GAINS
    gain, gain_error = found.gain_ratio, SD * found.gain_sd
    return [
        FigureRow(
            "Beat",
            abs(1 / beat - designed) <= PITCH_TOLERANCE / pitch_mm,
            f"The fringes of the reference row repeat every {beat:.2f} ± {beat_error:.2f} mm; the design has "
            f"{1 / designed:.2f} mm. The difference comes from errors of print scale and lens sheet.",
        ),
        FigureRow(
            "Gain",
            low <= gain <= high,
            f"They move {gain:.3f} ± {gain_error:.3f} times as far as the optics say.",
        ),
        FigureRow(
            "Twist",
            abs(twist) <= TWIST_DEG,
            f"The lens sheet is turned by {abs(twist):.3f} ± {twist_error:.3f}° against the lines, "
            f"{'clockwise' if twist >= 0 else 'anticlockwise'}.",
        ),
        FigureRow(
            "Offset",
            True,
            f"The lens nearest to the board's middle lies {1000 * abs(offset):.0f} ± {1000 * offset_error:.0f} µm to "
            f"its {ways[offset < 0]}. This is chance: any place is right, and in a copy the lens will lie elsewhere.",
        ),
    ]


router = APIRouter(include_in_schema=False)
Issuer = Annotated[Visitor, require("issuer")]


@router.get("/enroll")
def enroll_page(request: Request, visitor: Issuer, badge: str = "") -> Response:
    """The empty form, or one for the badge that a link names."""
    return _form(request, badge[:200])


@router.post("/enroll")
async def enroll(request: Request, visitor: Issuer) -> Response:
    """Take a film in, and let it be measured."""
    studio = studio_of(request)
    claim = ""
    try:
        async with studio.jobs.coming("capture", visitor.id, visitor.role) as job:
            form = await received(studio, request, job, ("claim",))
            claim = form.fields.get("claim", "").strip()
            if form.video is None:
                raise Refusal(422, "no_film", "No film was sent; choose one, or record one.")
            record = await run_in_threadpool(studio.registry.find, claim)
            await run_in_threadpool(start_capture, studio, job, form.video, record)
    except MoireIdError as error:
        return _form(request, claim, problem=studio.sentence(error), status=422)
    except Refusal as refusal:
        return _form(request, claim, problem=refusal.text, status=refusal.status)
    return RedirectResponse(f"/enroll/{job.id}", 303)


@router.get("/enroll/{job_id}")
def enroll_job(request: Request, job_id: str, visitor: Issuer) -> Response:
    """Progress, then what was measured."""
    studio = studio_of(request)
    job = studio.jobs.find(job_id, visitor.id, "capture")
    if job.state != "done":
        problem = studio.sentence(job.problem[1]) if job.problem else None
        return render(request, "making.html.j2", job=job, again="/enroll", problem=problem)
    record, compared = compared_of(studio, job)
    return _measured(request, job, record, compared, visitor)


@router.post("/enroll/{job_id}/keep")
def enroll_keep(
    request: Request, job_id: str, visitor: Issuer, reason: Annotated[str | None, Form(max_length=500)] = None
) -> Response:
    """Keep what was measured."""
    studio = studio_of(request)
    job = studio.jobs.find(job_id, visitor.id, "capture")
    return _measured(request, job, keep(studio, job, visitor, reason), None, visitor)


def _form(request: Request, claim: str, *, problem: str | None = None, status: int = 200) -> Response:
    studio = studio_of(request)
    shown = {"most_mb": studio.settings.limits.upload_bytes >> 20, "count": studio.registry.count()}
    return render(request, "enroll.html.j2", status=status, claim=claim, problem=problem, **shown)


def _measured(
    request: Request, job: Job, record: Record, compared: CaptureComparison | None, visitor: Visitor
) -> Response:
    """The page of what was measured; compared: None once it is kept."""
    found = as_built_of(job)
    return render(
        request,
        "enrolled.html.j2",
        job=job.id,
        record=record,
        compared=compared,
        figures=measured_words(found, record.badge),
        witnessed=found.witnessed,
        may_replace=visitor.may(),
    )
