"""From a visitor's form, or a film to try, to a job that waits: the same for the API and for the pages.

The films to try come with moireid: a true one and a forged one, of a badge that belongs to no one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from importlib import resources
from pathlib import Path
from typing import Literal

from fastapi import Request
from fastapi.concurrency import run_in_threadpool
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from moireid.question import CheckLevel
from moireid.verifier.limits import MIN_COVER_SHARE
from moireid.verifier.report.circumstances import ClaimNote as Named
from moireid_studio.auth.guard import Visitor
from moireid_studio.jobs.claims import note_claim
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio, studio_of
from moireid_studio.uploads import Form, receive


class FilmFields(BaseModel):
    """The fields of a form with a film, besides the film; an empty one counts as left out."""

    model_config = ConfigDict(extra="forbid")

    claim: str | None = Field(None, description="name or id of the person whose badge it is said to be")
    badge: str | None = Field(None, description="a badge.json in place of a claim")
    # The same range as for the command.
    focal_px: float | None = Field(None, ge=50, le=100_000, description="px; solved over the film if absent")
    cover: float = Field(
        MIN_COVER_SHARE,
        ge=0,
        le=1,
        description=f"share of the film that the verdict must be of; {MIN_COVER_SHARE:g} if absent",
    )
    level: CheckLevel | None = Field(
        None,
        description="what must be shown: record, the film agrees with the badge's design, and with its figures of "
        "enrolment where it has any; enrolled, there are such figures; live, a live check was passed, which a film "
        "cannot; if absent, record; this studio may ask for more",
    )
    kind: Literal["verify", "identify"] = "verify"


#: The kinds of jobs that judge a film, and the fields of each.
KINDS = ("verify", "identify")
VERIFY_FIELDS = ("claim", "badge", "focal_px", "cover", "level")
IDENTIFY_FIELDS = ("focal_px",)
#: Levels by what they ask.
STRICTEST_LAST: tuple[CheckLevel | None, ...] = (None, "record", "enrolled", "live")
Sample = Literal["true", "forged"]


async def start_job(request: Request, visitor: Visitor, *, kind: str | None = None, report: bool) -> Job:
    """Receive a film with its form, and let the job begin.

    Parameters
    ----------
    kind
        Verify or identify, None where the form's field `kind` says which.
    report
        Make the report too.

    Raises
    ------
    Refusal
        Where the form, the film or the claim cannot be used, or too many films wait.
    """
    studio = studio_of(request)
    async with studio.jobs.coming(kind or "verify", visitor.id, visitor.role) as job:
        fields = IDENTIFY_FIELDS if kind == "identify" else VERIFY_FIELDS if kind else ("kind", *VERIFY_FIELDS)
        form = await received(studio, request, job, fields)
        if form.video is None:
            raise Refusal(422, "fields", "The form has no film; send it as the file `video`.")
        given = _film_fields(form.fields)
        given.level = max(given.level, studio.settings.level, key=STRICTEST_LAST.index)
        job.kind = kind or given.kind
        job.film_name, job.claim, job.film_sha256 = form.name, given.claim or "", form.sha256
        await run_in_threadpool(submit_claim, studio, visitor, job, form.video, given, report=report)
    return job


def submit_claim(studio: Studio, visitor: Visitor, job: Job, video: Path, given: FilmFields, *, report: bool) -> None:
    """Let a job begin that judges a claim, or says who it is, as the registry knows it now; it is asked again as the
    film is judged.

    Parameters
    ----------
    video
        In the job's folder.
    given
        The fields of the form.
    report
        Make it too.

    Raises
    ------
    Refusal
        Where the claim is none, or means no one or several people.
    """
    wish = given.model_dump(exclude={"kind"}) | {"ids": visitor.may("issuer"), "report": report}
    if job.kind == "identify":
        job.label, job.standing = "who it is", studio.standing()
    elif (given.claim is None) == (given.badge is None):
        raise Refusal(
            422, "fields", "Say whose badge it is said to be: a name or an id as `claim`, or a badge.json as `badge`."
        )
    else:
        # What it traces is kept for the workers of this process.
        badge = note_claim(job, studio.registry, wish, studio.standing())[0].badge
        job.label = Named(badge.name, badge.id, job.claim_source == "registry").holder
    studio.jobs.submit(job, video, wish)


async def received(studio: Studio, request: Request, job: Job, fields: Collection[str]) -> Form:
    """A job's form, with its film in the job's folder.  Raises: Refusal as `receive` and `Jobs.stored`."""
    limits = studio.settings.limits
    return await receive(request, job.folder, limits, fields=fields, stored=lambda size: studio.jobs.stored(job, size))


def _film_fields(texts: Mapping[str, str]) -> FilmFields:
    """The fields of a form.  Raises: Refusal 422 where one cannot be used."""
    try:
        return FilmFields.model_validate({name: text.strip() for name, text in texts.items() if text.strip()})
    except ValidationError as error:
        first = error.errors()[0]
        raise Refusal(422, "fields", f"{first['loc'][0]} cannot be used: {first['msg']}.") from error


def start_sample(studio: Studio, visitor: Visitor, which: Sample) -> Job:
    """Let a sample be judged like any film that was sent.  Raises: Refusal 503 where too many films wait."""
    folder = resources.files("moireid_studio").joinpath("samples")
    film, badge = folder.joinpath(f"{which}.mp4").read_bytes(), folder.joinpath("badge.json").read_text("utf-8")
    with studio.jobs.receiving("verify", visitor.id) as job:
        (job.folder / "film.mp4").write_bytes(film)
        job.film_name, job.film_sha256 = f"sample, {which}.mp4", hashlib.sha256(film).hexdigest()
        submit_claim(
            studio, visitor, job, job.folder / "film.mp4", FilmFields.model_validate({"badge": badge}), report=True
        )
    return job
