"""The First badge pages: from a lens sheet and a printer to a badge that is built and measured.

They show what `moireid first-badge` shows, of a folder that the studio keeps, and add no steps of their own.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from fastapi import APIRouter, Form, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import FileResponse, RedirectResponse, Response
from pydantic import BaseModel, Field

from moireid.bringup.build_folder import BADGE_FILMS, CAMERA_FILM, SHEET_FILM, SHEET_PHOTO, Wish
from moireid.designer.order import clean_name, parse_scale
from moireid.errors import MoireIdError
from moireid.sheets import DEFAULT_LENS, MM_PER_INCH, PRODUCTS
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.build_jobs import SLOTS, last_job, receive_media, remove_build, start_round
from moireid_studio.forms import ShortRoute, picture_fields
from moireid_studio.jobs.orders import LensLabel, read_fields
from moireid_studio.pages.home import render
from moireid_studio.problems import Refusal
from moireid_studio.store.build_store import FOLDER, KEEP_DAYS, RECORD, Build
from moireid_studio.studio import Studio, studio_of

#: What is sent, in words.
SLOT_WORDS = {
    SHEET_PHOTO: "The photo of the pitch test",
    SHEET_FILM: "A film of the pitch test, if you have no calliper",
    CAMERA_FILM: "The film of the camera chart",
    BADGE_FILMS[0]: "The first film of the badge",
    BADGE_FILMS[1]: "The second film of the badge",
}
#: Marks of the steps' states (`progress_page.step_state`), and the colours of words.
MARKS = {"done": "✓", "next": "→", "not usable": "✗", "left out": "–", "to come": "·"}
FIGURE_MARKS = {"good": ("pass", "✓ good"), "look": ("undecided", "! look at it"), "unknown": ("note", "? not known")}
REPORT = "report.html"
#: What may be downloaded: place in the build's work, type, and words.
PDF, JSON = "application/pdf", "application/json"
FILES = {
    "pitch-test.pdf": (f"{FOLDER}/pitch-test.pdf", PDF, "the pitch test, to print at 100 %"),
    "camera-chart.pdf": (f"{FOLDER}/camera-chart.pdf", PDF, "the camera chart, to print at 100 %"),
    "badge.pdf": (f"{FOLDER}/badge/badge.pdf", PDF, "the badge, to print at 100 %"),
    "assembly.pdf": (f"{FOLDER}/badge/assembly.pdf", PDF, "how to build the badge"),
    "badge.json": (f"{FOLDER}/badge/badge.json", JSON, "the badge; keep it as you would keep a key"),
    "sheet.json": (f"{FOLDER}/sheet.json", JSON, "your lens sheet, for print-your-badge --lens"),
    "printer.json": (f"{FOLDER}/printer.json", JSON, "your printer, for print-your-badge --printer"),
    "camera.yaml": (f"{FOLDER}/camera.yaml", "application/yaml", "your camera, for moireid verify --camera"),
    "as-built.json": (f"{FOLDER}/as-built.json", JSON, "the badge as it was built"),
    "record.json": (RECORD, JSON, "the capture record, to share"),
}
#: The report was made by a process that reads strangers' films: nothing in it may run or be loaded.
REPORT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'; sandbox"
LENSES = [(label, f"{MM_PER_INCH / one.pitch_mm:g} LPI, {one.thickness_mm:.3g} mm") for label, one in PRODUCTS.items()]
NOTE_CHARACTERS = 2000

router = APIRouter(prefix="/first-badge", include_in_schema=False, route_class=ShortRoute)
Issuer = Annotated[Visitor, require("issuer")]


class HandFields(BaseModel):
    """What the builder measures by hand; an empty field is not known."""

    thickness_mm: float | None = Field(None, gt=0, le=20, allow_inf_nan=False)
    measured_scale: str = ""
    distance_m: float | None = Field(None, gt=0, le=100, allow_inf_nan=False)
    focal_px: float | None = Field(None, ge=50, le=100_000)

    def wish(self, before: Wish) -> Wish:
        """The wish with these figures.  Raises: SpecError for an impossible scale."""
        scale = parse_scale(self.measured_scale) if self.measured_scale else None
        return msgspec.structs.replace(
            before,
            thickness_mm=self.thickness_mm,
            measured_scale=scale,
            distance_m=self.distance_m,
            focal_px=self.focal_px,
        )


class BeginFields(BaseModel):
    """What a build is begun for."""

    name: str = ""
    lens: LensLabel = DEFAULT_LENS
    printer_dpi: int = Field(1200, ge=72, le=9600)
    paper: Literal["a4", "letter"] = "a4"
    thickness_mm: float | None = Field(None, gt=0, le=20, allow_inf_nan=False)

    def wish(self) -> Wish:
        """The same for the steps.  Raises: SpecError for an impossible name."""
        return Wish(clean_name(self.name), self.lens, self.printer_dpi, self.paper, self.thickness_mm)


@router.get("")
def first_badge_page(request: Request, visitor: Issuer) -> Response:
    """The visitor's builds, and the form that begins one."""
    return _list(request, visitor, {})


@router.post("")
async def begin(request: Request, visitor: Issuer) -> Response:
    """Begin a build, and draw its pitch test."""
    sent = await picture_fields(request, visitor, {})
    return await run_in_threadpool(_begin, request, visitor, sent.texts)


def _begin(request: Request, visitor: Visitor, texts: dict[str, str]) -> Response:
    studio = studio_of(request)
    try:
        build = studio.builds.begin(visitor.id, read_fields(BeginFields, texts).wish())
        start_round(studio, visitor, build.id)
    except (MoireIdError, Refusal) as error:
        return _list(request, visitor, texts, problem=studio.sentence(error), status=getattr(error, "status", 422))
    return RedirectResponse(f"/first-badge/{build.id}", 303)


@router.get("/{build_id}")
def build_page(request: Request, build_id: str, visitor: Issuer) -> Response:
    """The steps of a build, what is to be done next, and what was measured."""
    studio = studio_of(request)
    return _build(request, studio.builds.find(build_id, visitor.id))


@router.post("/{build_id}/media/{slot}")
async def send_media(request: Request, build_id: str, slot: str, visitor: Issuer) -> Response:
    """Take a photo or film in, and let it be read."""
    if slot not in SLOTS:
        raise _no_file()
    try:
        await receive_media(request, visitor, build_id, slot)
    except Refusal as refusal:
        if refusal.status == 404:
            raise
        return await run_in_threadpool(_build_again, request, visitor, build_id, refusal)
    return RedirectResponse(f"/first-badge/{build_id}", 303)


@router.post("/{build_id}/round")
async def read_again(request: Request, build_id: str, visitor: Issuer) -> Response:
    """Read what is there again, with what was measured by hand."""
    sent = await picture_fields(request, visitor, {})
    return await run_in_threadpool(_round, request, visitor, build_id, sent.texts)


def _round(request: Request, visitor: Visitor, build_id: str, texts: dict[str, str]) -> Response:
    studio = studio_of(request)
    build = studio.builds.find(build_id, visitor.id)
    try:
        wish = read_fields(HandFields, texts).wish(build.note.wish) if texts else None
        start_round(studio, visitor, build.id, wish=wish)
    except (MoireIdError, Refusal) as error:
        return _build_again(request, visitor, build_id, error)
    return RedirectResponse(f"/first-badge/{build_id}", 303)


@router.post("/{build_id}/record")
async def make_record(request: Request, build_id: str, visitor: Issuer) -> Response:
    """Make the capture record."""
    sent = await picture_fields(request, visitor, {})
    return await run_in_threadpool(_record, request, visitor, build_id, sent.texts)


def _record(request: Request, visitor: Visitor, build_id: str, texts: dict[str, str]) -> Response:
    note = texts.get("note", "").strip().replace("\r\n", "\n")
    try:
        if len(note) > NOTE_CHARACTERS:
            raise Refusal(422, "fields", f"The note has {len(note)} characters, at most {NOTE_CHARACTERS} fit.")
        asked = {"with_badge": bool(texts.get("with_badge")), "note": note}
        start_round(studio_of(request), visitor, build_id, record=asked)
    except Refusal as refusal:
        if refusal.status == 404:
            raise
        return _build_again(request, visitor, build_id, refusal)
    return RedirectResponse(f"/first-badge/{build_id}", 303)


@router.post("/{build_id}/delete")
def delete_build(
    request: Request, build_id: str, visitor: Issuer, sure: Annotated[Literal["true"], Form()]
) -> Response:
    """Remove a build with all its films."""
    studio = studio_of(request)
    remove_build(studio, studio.builds.find(build_id, visitor.id))
    return RedirectResponse("/first-badge", 303)


@router.get("/{build_id}/report")
def build_report(request: Request, build_id: str, visitor: Issuer) -> Response:
    """The report, as a page in which nothing runs."""
    path = studio_of(request).builds.find(build_id, visitor.id).file(f"{FOLDER}/{REPORT}")
    if path is None:
        raise _no_file()
    headers = {"Content-Security-Policy": REPORT_POLICY}
    return FileResponse(path, media_type="text/html; charset=utf-8", headers=headers)


@router.get("/{build_id}/files/{name}")
def build_file(request: Request, build_id: str, name: str, visitor: Issuer) -> Response:
    """A file to keep."""
    build = studio_of(request).builds.find(build_id, visitor.id)
    place, kind, _ = FILES.get(name, ("", "", ""))
    if not place or (path := build.file(place)) is None:
        raise _no_file()
    return FileResponse(path, media_type=kind, filename=name)


def _no_file() -> Refusal:
    return Refusal(404, "no_file", "There is no such file, or it is not made yet.")


def _list(
    request: Request, visitor: Visitor, given: dict[str, str], *, problem: str | None = None, status: int = 200
) -> Response:
    studio = studio_of(request)
    builds = [(build, _words(studio, build)) for build in studio.builds.of(visitor.id)]
    shown = {"builds": builds, "given": given, "problem": problem, "lenses": LENSES, "keep_days": KEEP_DAYS}
    return render(request, "first_badge.html.j2", status=status, **shown)


def _words(studio: Studio, build: Build) -> str:
    """How far a build is, in some words."""
    from moireid.bringup.bring_up import STEPS

    if (job := last_job(studio, build)) is not None and not job.over:
        return "being read"
    if (came := build.round()) is None:
        return "not begun"
    return next((step.title for step in STEPS if step.name == came.next_step), "done")


def _build_again(request: Request, visitor: Visitor, build_id: str, error: Refusal | MoireIdError) -> Response:
    """The page of a build with what was wrong with what was sent."""
    studio = studio_of(request)
    build = studio.builds.find(build_id, visitor.id)
    return _build(request, build, problem=studio.sentence(error), status=getattr(error, "status", 422))


def _build(request: Request, build: Build, *, problem: str | None = None, status: int = 200) -> Response:
    from moireid.bringup.progress_page import shown_value, step_state

    studio, advance = studio_of(request), _advance(build)
    job = last_job(studio, build)
    if job is not None and job.problem is not None:
        problem = problem or studio.sentence(job.problem[1])
    shown: dict[str, Any] = {
        "build": build,
        "wish": build.note.wish,
        "lenses": dict(LENSES),
        "problem": problem,
        "job": None if job is None or job.over else job,
        "advance": advance,
        "steps": [] if advance is None else [(step, step_state(advance, step.name)) for step in advance.steps],
        "marks": MARKS,
        "failed": job is not None and job.problem is not None,
        "figures": [] if advance is None else advance.folder.figures(),
        "figure_marks": FIGURE_MARKS,
        "shown_value": shown_value,
        "slot_words": SLOT_WORDS,
        "photo": SHEET_PHOTO,
        "files": [(name, words) for name, (place, _, words) in FILES.items() if build.file(place)],
        "measured": build.file(f"{FOLDER}/films.json") is not None,
        "report": build.file(f"{FOLDER}/{REPORT}") is not None,
        "most_mb": studio.settings.limits.upload_bytes >> 20,
        "keep_days": KEEP_DAYS,
    }
    return render(request, "build.html.j2", status=status, **shown)


def _advance(build: Build) -> Any:
    """What the last round came to, in the words of a page; None before the first."""
    from moireid.bringup.bring_up import STEPS, Advance
    from moireid_studio.jobs.build_round import in_page_words

    if (came := build.round()) is None:
        return None
    step = next((step for step in STEPS if step.name == came.next_step), None)
    return in_page_words(Advance(build.state(), STEPS, tuple(came.did), step, came.refused))
