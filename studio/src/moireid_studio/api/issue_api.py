"""The API of issuing and enrolling: what the pages do, for programs."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Path, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from moireid_studio.api.films import JobId, JobStatus, add_job_routes, status_of
from moireid_studio.api.schema import form, picture_form
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.checks import received
from moireid_studio.forms import ShortRoute, picture_fields
from moireid_studio.issue_jobs import file_of, keep, package_of, pictures_of, start_badge, start_capture
from moireid_studio.jobs.orders import VisitorOrder, checked
from moireid_studio.pictures import at_hand, keep_pictures, read_picture
from moireid_studio.problems import Refusal, plain, problem_responses
from moireid_studio.studio import studio_of

router = APIRouter(prefix="/api/badges", route_class=ShortRoute, responses=problem_responses(401, 403, 422))
Issuer = Annotated[Visitor, require("issuer")]
BadgeId = Annotated[str, Path(pattern="^[0-9a-fA-F]{4,64}$", description="A badge's identity, hex digits.")]
KINDS = ("badge", "event", "capture")
FILES = {"assembly.pdf": "application/pdf", "mount.glb": "model/gltf-binary", "preview.png": "image/png"}


class LinkPoint(BaseModel):
    """The link budget at one distance."""

    distance_m: float
    cell_px: float
    phase_error_rad: float
    decode_probability: float


class CheckAnswer(BaseModel):
    """A badge that can be made; nothing is issued."""

    id: str
    name: str
    already_issued: bool = Field(description="This very badge is in the registry already.")
    namesakes: list[str] = Field(description="Ids of other badges of that name.")
    look_alikes: list[str] = Field(description="Ids of badges whose names look like it, in other letters or case.")
    explain: dict[str, str]
    link_budget: list[LinkPoint]
    files: list[str] = Field(description="Files of the mount.")
    left_out: dict[str, str] = Field(description="Which of the two mounts cannot be made, and why.")
    note: str | None = Field(description="On letters that no font has, and on a mount that is not made.")
    badge: dict[str, Any] = Field(description="badge.json.")


class PictureAnswer(BaseModel):
    """A picture that was read, and is kept for you alone until it is removed."""

    id: str = Field(description="What `logo` or `portrait` of an order says.")
    bytes: int = Field(description="Size of what is kept: a PNG or JPEG of our own making.")
    kept_s: float = Field(description="How long it is kept.")


class AsBuiltAnswer(BaseModel):
    """A badge's figures as they are kept from now on."""

    id: str
    name: str
    as_built_at: str
    as_built: dict[str, Any]
    earlier: int = Field(description="How many sets of figures that were in use before are on record, and count too.")


class KeepOrder(BaseModel):
    """How to keep what a capture measured."""

    replace_reason: str | None = Field(
        None,
        max_length=500,
        description="Why the figures take the place of those in use; needed where they differ. Admins only.",
    )


@router.post("/check", responses=problem_responses(400, 413))
def check(request: Request, order: VisitorOrder, visitor: Issuer) -> CheckAnswer:
    """What would be made of an order: the badge, its link budget, and what could not be made.

    An identity that the order does not name is drawn; give the answer's `id` as `payload` to issue this very badge.
    """
    studio = studio_of(request)
    with at_hand(pictures_of(studio, order, visitor)) as files:
        found = checked(order, studio.registry, files)
    links = [LinkPoint(distance_m=metres, **asdict(link)) for metres, link in found.links]
    return CheckAnswer(
        id=found.plan.badge.id or "",
        name=found.plan.badge.name,
        already_issued=found.plan.holder is not None,
        namesakes=[record.id for record in found.namesakes],
        look_alikes=[record.id for record in found.look_alikes],
        explain=dict(found.rows),
        link_budget=links,
        files=list(found.plan.parts.files),
        left_out={shop: plain(why) for shop, why in found.plan.parts.left_out.items()},
        note="; ".join(found.plan.notes) or None,
        badge=json.loads(found.plan.badge.to_json()),
    )


@router.post("", status_code=202, responses=problem_responses(400, 413, 503))
def issue(request: Request, order: VisitorOrder, visitor: Issuer) -> JobStatus:
    """Issue a badge and make its package: a job, whose end offers package.zip."""
    studio = studio_of(request)
    pictures = pictures_of(studio, order, visitor)
    # Checked now, so that a faulty order is refused before a job begins.
    with at_hand(pictures) as files:
        found = checked(order, studio.registry, files)
    return status_of(start_badge(studio, replace(order, payload=found.plan.badge.id), visitor, pictures))


@router.post(
    "/pictures",
    status_code=201,
    responses=problem_responses(400, 408, 413, 503),
    openapi_extra=picture_form(),
)
async def picture(request: Request, visitor: Issuer) -> PictureAnswer:
    """Hand in a logo or a portrait for an order: SVG, PNG or JPEG, read as the command reads it.

    Of an SVG with scripts, letters that need a font, filters or anything from elsewhere the answer says what to change.
    """
    studio = studio_of(request)
    sent = await picture_fields(request, visitor, {"picture": 1})
    if "picture" not in sent.pictures:
        raise Refusal(422, "fields", "The form has no picture; send it as the file `picture`.")
    limits = studio.settings.limits
    made = await run_in_threadpool(read_picture, "picture", sent.pictures["picture"][0], limits)
    kept = await run_in_threadpool(keep_pictures, studio, visitor, {"picture": made})
    return PictureAnswer(id=kept, bytes=len(made.data), kept_s=limits.keep_s)


add_job_routes(router, "issuer", KINDS)


@router.get(
    "/jobs/{job_id}/package.zip",
    responses=problem_responses(404)
    | {200: {"content": {"application/zip": {}}, "description": "everything that was made"}},
    response_class=FileResponse,
)
def package(request: Request, job_id: JobId, visitor: Issuer) -> FileResponse:
    """Everything that a job has made, as one archive."""
    return package_of(studio_of(request).jobs.find(job_id, visitor.id, "badge", "event"))


@router.get(
    "/jobs/{job_id}/{name}",
    responses=problem_responses(404) | {200: {"content": {kind: {} for kind in FILES.values()}}},
    response_class=Response,
)
def one_file(
    request: Request, job_id: JobId, visitor: Issuer, name: Literal["assembly.pdf", "mount.glb", "preview.png"]
) -> Response:
    """One of the files of a badge that a job has made: how it is built or looks, or the parts of its mount in 3D."""
    found = studio_of(request).jobs.find(job_id, visitor.id, "badge")
    return Response(file_of(found, name), media_type=FILES[name])


@router.post(
    "/{badge_id}/captures",
    status_code=202,
    responses=problem_responses(400, 404, 408, 413, 415, 503),
    openapi_extra=form(),
)
async def capture(request: Request, badge_id: BadgeId, visitor: Issuer) -> JobStatus:
    """Measure a badge as built from a film of it: a job, whose end offers the figures; they are not kept yet."""
    studio = studio_of(request)
    record = await run_in_threadpool(studio.record, badge_id)
    async with studio.jobs.coming("capture", visitor.id, visitor.role) as begun:
        sent = await received(studio, request, begun, ())
        if sent.video is None:
            raise Refusal(422, "fields", "The form has no film; send it as the file `video`.")
        return status_of(await run_in_threadpool(start_capture, studio, begun, sent.video, record))


@router.post("/{badge_id}/captures/{job_id}/keep", responses=problem_responses(400, 403, 404, 409))
def keep_capture(
    request: Request, badge_id: BadgeId, job_id: JobId, visitor: Issuer, order: KeepOrder | None = None
) -> AsBuiltAnswer:
    """Keep what a capture measured as the badge's figures; figures that agree with those in use change nothing."""
    studio = studio_of(request)
    found = studio.jobs.find(job_id, visitor.id, "capture")
    if found.result is not None and found.result["id"] != badge_id.lower():
        raise Refusal(404, "no_job", "There is no such job of this badge.")
    record = keep(studio, found, visitor, order.replace_reason if order else None)
    assert record.as_built is not None and record.as_built_at is not None
    return AsBuiltAnswer(
        id=record.id,
        name=record.name,
        as_built_at=record.as_built_at,
        as_built=json.loads(record.as_built),
        earlier=len(record.earlier_figures),
    )
