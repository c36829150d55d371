"""From a visitor's form, or a film to try, to a job that waits: the same for the API and for the pages.

The films to try come with moireid: a true one and a forged one, of a badge that belongs to no one.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection, Mapping
from importlib import resources
from pathlib import Path
from typing import Any, Literal

from fastapi import Request
from fastapi.concurrency import run_in_threadpool

from moireid.verifier.limits import MIN_COVER_SHARE
from moireid.verifier.report.circumstances import ClaimNote as Named
from moireid_studio.auth.guard import Visitor
from moireid_studio.jobs.claims import claim_of
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio, studio_of
from moireid_studio.uploads import Form, receive

#: Allowed focal lengths, px; the same as for the command.
FOCAL_PX = (50.0, 100_000.0)
#: The kinds of jobs that judge a film.
KINDS = ("verify", "identify")
VERIFY_FIELDS = ("claim", "badge", "focal_px", "require_original", "cover", "photographs")
#: The most photographs that may be asked for.
MOST_PHOTOGRAPHS = 1000
IDENTIFY_FIELDS = ("focal_px",)
Sample = Literal["true", "forged"]


async def start_job(request: Request, visitor: Visitor, *, kind: str | None = None, report: bool) -> Job:
    """Receive a film with its form, and let the job begin.

    Parameters: kind: verify or identify, None where the form's field `kind` says which; report: make the report too.
    Raises: Refusal where the form, the film or the claim cannot be used, or too many films wait.
    """
    studio = studio_of(request)
    async with studio.jobs.coming(kind or "verify", visitor.id, visitor.role) as job:
        fields = IDENTIFY_FIELDS if kind == "identify" else VERIFY_FIELDS if kind else ("kind", *VERIFY_FIELDS)
        form = await received(studio, request, job, fields)
        # A field that was not filled in arrives as an empty text.
        given = {name: text.strip() for name, text in form.fields.items() if text.strip()}
        if form.video is None:
            raise Refusal(422, "fields", "The form has no film; send it as the file `video`.")
        job.kind = given.get("kind", job.kind)
        if job.kind not in KINDS:
            raise Refusal(422, "fields", "The field kind is verify or identify.")
        job.film_name, job.claim, job.film_sha256 = form.name, given.get("claim", ""), form.sha256
        await run_in_threadpool(submit_claim, studio, visitor, job, form.video, given, report=report)
    return job


def submit_claim(
    studio: Studio, visitor: Visitor, job: Job, video: Path, given: Mapping[str, str], *, report: bool
) -> None:
    """Let a job begin that judges a claim, or says who it is.

    Parameters: video: in the job's folder; given: the fields of the form that have a value; report: make it too.
    Raises: Refusal where the claim or a figure cannot be used.
    """
    wish = _wish(given, ids=visitor.may("issuer"), report=report)
    _look_up(studio, job, wish)
    studio.jobs.submit(job, video, wish)


async def received(studio: Studio, request: Request, job: Job, fields: Collection[str]) -> Form:
    """A job's form, with its film in the job's folder.  Raises: Refusal as `receive` and `Jobs.stored`."""
    limits = studio.settings.limits
    return await receive(request, job.folder, limits, fields=fields, stored=lambda size: studio.jobs.stored(job, size))


def _wish(given: Mapping[str, str], *, ids: bool, report: bool) -> dict[str, Any]:
    """What is to be done with a film, as JSON.  Raises: Refusal 422 where a field cannot be used."""
    return {
        "claim": given.get("claim"),
        "badge": given.get("badge"),
        "ids": ids,
        "focal_px": None if "focal_px" not in given else _number(given, "focal_px", *FOCAL_PX, 0.0),
        "require_original": _truth(given.get("require_original")),
        "cover_share": _number(given, "cover", 0, 1, MIN_COVER_SHARE),
        "photographs": int(_number(given, "photographs", 0, MOST_PHOTOGRAPHS, 0)),
        "report": report,
    }


def _look_up(studio: Studio, job: Job, wish: dict[str, Any]) -> None:
    """Whose badge a job's film is said to show, as the registry knows it now; it is asked again as the film is judged.

    Raises: Refusal where the claim is none, or means no one or several people.
    """
    if job.kind == "identify":
        job.label, job.standing = "who it is", studio.standing()
        return
    if (wish["claim"] is None) == (wish["badge"] is None):
        raise Refusal(
            422, "fields", "Say whose badge it is said to be: a name or an id as `claim`, or a badge.json as `badge`."
        )
    job.standing = studio.standing()
    # What it traces is kept for the workers of this process.
    found, _ = claim_of(studio.registry, wish, job.standing)
    job.claimed_id, job.claim_source = found.badge.id, found.provenance.source
    vouched = found.provenance.source == "registry"
    job.label, job.barred = Named(found.badge.name, found.badge.id, vouched).holder, found.barred


def _number(given: Mapping[str, str], name: str, least: float, most: float, otherwise: float) -> float:
    """A number of the form.  Raises: Refusal where it is none, or out of its range."""
    if name not in given:
        return otherwise
    try:
        value = float(given[name])
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise Refusal(422, "fields", f"{name} is a number from {least:g} to {most:g}.")
    return value


def _truth(text: str | None) -> bool | None:
    if text is None:
        return None
    if text.lower() in ("false", "0", "off"):
        return False
    if text.lower() in ("true", "1", "on"):
        return True
    raise Refusal(422, "fields", "require_original is true or false.")


def start_sample(studio: Studio, visitor: Visitor, which: Sample) -> Job:
    """Let a sample be judged like any film that was sent.  Raises: Refusal 503 where too many films wait."""
    folder = resources.files("moireid_studio").joinpath("samples")
    film, badge = folder.joinpath(f"{which}.mp4").read_bytes(), folder.joinpath("badge.json").read_text("utf-8")
    with studio.jobs.receiving("verify", visitor.id) as job:
        (job.folder / "film.mp4").write_bytes(film)
        job.film_name, job.film_sha256 = f"sample, {which}.mp4", hashlib.sha256(film).hexdigest()
        submit_claim(studio, visitor, job, job.folder / "film.mp4", {"badge": badge}, report=True)
    return job
