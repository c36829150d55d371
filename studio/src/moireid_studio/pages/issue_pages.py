"""The Issue pages: one person, or everyone at an event; their choices, and the link budget in words.

Pictures come with a form once: what is read of them is kept, and when the form is shown again it names them (`kept`).
"""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from fastapi import APIRouter, Request
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import RedirectResponse, Response

from moireid.designer.formats import FORMATS
from moireid.designer.list_table import decoded
from moireid.designer.reach import verdict_reach_m
from moireid.errors import MoireIdError, SpecError
from moireid.fabrication.page.preview import draw_preview
from moireid.issuing import Package
from moireid.names import line_of
from moireid_studio.auth.guard import Visitor, require
from moireid_studio.forms import Fields, picture_fields
from moireid_studio.issue_jobs import start_badge, start_event
from moireid_studio.jobs.lists import FOR_ALL, MOST_AT_AN_EVENT, picture_key, understood
from moireid_studio.jobs.orders import CheckedOrder, checked, read_order
from moireid_studio.pages.home import render
from moireid_studio.pictures import at_hand, keep_pictures, kept_pictures, read_pictures
from moireid_studio.store.stored_pictures import StoredPicture
from moireid_studio.studio import Studio, studio_of

#: The formats: what they are called, and what they go into; sizes and ranges are said by `FORMATS`.
FORMAT_WORDS = {
    "board": ("Board", "in a mount of its own, for cameras farther away"),
    "cr80": ("Card", "in a card holder, as large as a credit card"),
    "a7": ("A7", "in an A7 pouch"),
    "4x3in": ("4 × 3 inches", "in a pouch of that size"),
    "a6": ("A6", "in an A6 pouch"),
    "a5": ("A5", "in an A5 pouch, or as a sign on a desk"),
    "webcam": ("Video call", "in the hand or on a stand, before a laptop's camera"),
}
#: What the templates are: value, name, words, and the picture that shows one; without a value the usual one is taken.
TEMPLATES = [
    ("", "As usual", "The name, and next to or above it lines and pictures. For video calls: large letters.", "plain"),
    ("conference", "Conference", "A large name on a band in your colour, the logo above it.", "conference"),
    ("newsroom", "Newsroom", "A press card: the portrait, name and lines, the logo.", "newsroom"),
    ("court", "Court", "Sober: name and office between two lines, the seal above.", "court"),
    ("webcam", "Video call", "Name and lines as large as there is room.", "webcam"),
    ("banner", "Banner", "The name in white on your colour, from edge to edge.", "banner"),
    ("campus", "Campus", "In a serif, the portrait next to the name.", "campus"),
    ("minimal", "Minimal", "Name and lines at the left, nothing else.", "minimal"),
]


def _formats() -> list[tuple[str, str]]:
    """Each format for a list: its value, and in words its name, size, from where it is filmed, and its holder."""
    formats = []
    for value, (name, where) in FORMAT_WORDS.items():
        form = FORMATS[value]
        size = " × ".join(f"{side:g}" for side in form.size_mm)
        near, far = form.range_m
        formats.append((value, f"{name}: {size}\u00a0mm, filmed from {near:g} to {far:g}\u00a0m, {where}"))
    return formats


#: For the templates of the pages; in `styles` the plain one has the value that leaves the choice to the format.
CHOICES: dict[str, Any] = {"formats": _formats(), "styles": TEMPLATES}


def sentences(checked: CheckedOrder, format_name: str | None = None) -> list[str]:
    """What a person should know before a badge is made: from where it can be read, and how surely."""
    badge = checked.plan.badge
    camera = "in a call, by a camera of 720p" if format_name == "webcam" else "with a phone at 1080p"
    assert badge.range_m is not None
    lines = [
        f"Badge {badge.id} carries {badge.payload_bits} bits, and is made to be filmed from {badge.range_m[0]:g} to "
        f"{badge.range_m[1]:g} m {camera}."
    ]
    chances = {metres: _chance(link.decode_probability) for metres, link in checked.links}
    if len(set(chances.values())) == 1:
        lines.append(f"Over all of that the identity is read {next(iter(chances.values()))}.")
    else:
        lines += [f"From {metres:g} m the identity is read {chance}." for metres, chance in chances.items()]
    reach_m, far_m = verdict_reach_m(badge), badge.range_m[1]
    until = "" if reach_m >= far_m else f" up to {reach_m:.1f} m; from farther away, move it more"
    lines.append(f"Move badge or camera while filming. Eight seconds of swaying are enough for a verdict{until}.")
    return lines


def _chance(probability: float) -> str:
    """A probability as a share of films."""
    if probability >= 0.9999:
        return "in practically every film of eight seconds"
    if probability >= 0.01:
        return f"in about {100 * probability:.{0 if probability < 0.99 else 1}f} of 100 films of eight seconds"
    return "in hardly any film"


#: Longer side of the picture of a badge, px.
PICTURE_PX = 900
router = APIRouter(include_in_schema=False)
Issuer = Annotated[Visitor, require("issuer")]
#: The fields of the forms that hold pictures, and how many each may have: of a list two for each person.
OF_ONE, OF_EVENT = {"logo": 1, "portrait": 1}, {"logo": 1, "pictures": 2 * MOST_AT_AN_EVENT}


@router.get("/issue")
def issue_page(request: Request, visitor: Issuer) -> Response:
    """The empty form."""
    return _page(request, {})


@router.post("/issue")
async def issue(request: Request, visitor: Issuer) -> Response:
    """Show what would be made; or make it, if the visitor need not see a warning first."""
    sent = await picture_fields(request, visitor, OF_ONE)
    return await run_in_threadpool(_issue, request, sent, visitor)


def _issue(request: Request, sent: Fields, visitor: Visitor) -> Response:
    studio = studio_of(request)
    chosen = _Chosen(studio, visitor, sent)
    try:
        chosen.read({what: what for what in OF_ONE})
        texts = _texts(sent)
        # What was drawn to be shown is what is issued then.
        order = read_order(texts | {"payload": texts.get("payload", "").strip() or texts.get("drawn", "")})
        with at_hand(chosen.pictures) as files:
            found = checked(order, studio.registry, files)
            was_shown = found.to_read is None or sent.texts.get("acknowledged") == found.to_read
            if sent.texts.get("do") == "issue" and was_shown:
                job = start_badge(studio, replace(order, payload=found.plan.badge.id), visitor, chosen.pictures)
                return RedirectResponse(f"/issue/jobs/{job.id}", 303)
            seen = _picture(found.plan)
    except MoireIdError as error:
        problem = studio.sentence(error)
        return _page(request, sent.texts, status=422, chosen=chosen.shown(), problem=problem)
    words = sentences(found, order.format)
    line, kept, held_up = line_of(found.plan.badge.print), chosen.shown(), sent.texts.get("do") == "issue"
    return _page(
        request, sent.texts, chosen=kept, checked=found, seen=seen, line=line, sentences=words, held_up=held_up
    )


def _picture(plan: Package) -> str:
    """The badge with all that it wears, as the address of a picture."""
    made = io.BytesIO()
    picture = draw_preview(plan.badge)
    picture.thumbnail((PICTURE_PX, PICTURE_PX))
    picture.save(made, format="WEBP", quality=80)
    return "data:image/webp;base64," + base64.b64encode(made.getvalue()).decode()


@router.get("/issue/event")
def event_page(request: Request, visitor: Issuer) -> Response:
    """The empty form."""
    return _event_page(request, {}, "")


@router.post("/issue/event")
async def event(request: Request, visitor: Issuer) -> Response:
    """Show how the list was understood; or issue all badges, if no row has a fault."""
    sent = await picture_fields(request, visitor, OF_EVENT)
    return await run_in_threadpool(_event, request, sent, visitor)


def _event(request: Request, sent: Fields, visitor: Visitor) -> Response:
    studio = studio_of(request)
    data = sent.files.get("people_file") or sent.texts.get("people", "").encode("utf-8", "replace")
    chosen, text = _Chosen(studio, visitor, sent), ""
    try:
        if not data.strip():
            raise SpecError("no list was given; choose a file, or type a name on each line below a first line “name”")
        text = decoded(data)
        chosen.read({"logo": FOR_ALL, "pictures": None})
        order = read_order(_texts(sent) | {"name": "Everybody", "payload": ""})
        with at_hand(chosen.pictures) as files:
            rows, notes = understood(data, order, studio.registry, files)
        faults = sum(row["fault"] is not None for row in rows)
        if sent.texts.get("do") == "issue" and not faults:
            job = start_event(studio, data, order, visitor, chosen.pictures)
            return RedirectResponse(f"/issue/jobs/{job.id}", 303)
    except MoireIdError as error:
        problem = studio.sentence(error)
        return _event_page(request, sent.texts, text, status=422, chosen=chosen.shown(), problem=problem)
    return _event_page(
        request,
        sent.texts,
        text,
        status=422 if faults else 200,
        chosen=chosen.shown(),
        rows=rows,
        faults=faults,
        notes=notes,
        sound=not faults,
    )


@router.get("/issue/jobs/{job_id}")
def issue_job(request: Request, job_id: str, visitor: Issuer) -> Response:
    """Progress, then the package."""
    studio = studio_of(request)
    job = studio.jobs.find(job_id, visitor.id, "badge", "event")
    if job.state != "done":
        again = "/issue" if job.kind == "badge" else "/issue/event"
        problem = studio.sentence(job.problem[1]) if job.problem else None
        return render(request, "making.html.j2", job=job, again=again, problem=problem)
    minutes = round(studio.settings.limits.keep_s / 60)
    made = job.result or {}
    model = "mount.glb" if "mount.glb" in made.get("files", ()) else None
    return render(request, "issued.html.j2", job=job, made=made, minutes=minutes, model=model)


@dataclass
class _Chosen:
    """The pictures of a form: those that came with it now, and those that are kept since it came before."""

    studio: Studio
    visitor: Visitor
    sent: Fields
    pictures: dict[str, StoredPicture] = field(default_factory=dict)
    #: Where `pictures` are kept; empty where they are not, or where what is kept is not all of them.
    kept: str = ""

    def read(self, keys: Mapping[str, str | None]) -> None:
        """Read the form's pictures; those that can be used stay, whatever is wrong with another.

        Parameters
        ----------
        keys
            By which key a field's picture is known; None: by the name of its file.

        Raises
        ------
        SpecError
            For the first that cannot be used, or has the name of another.
        Refusal
            As `read_pictures`.
        """
        faults = []
        try:
            self._recall(keys)
        except SpecError as error:
            faults.append(error)
        came = [(what, one) for what in keys for one in self.sent.pictures.get(what, [])]
        named = [("picture" if keys[what] is None else what, one) for what, one in came]
        here: set[str] = set()
        for (what, one), made in zip(came, read_pictures(named, self.studio.settings.limits), strict=True):
            key = keys[what] or picture_key(one.name)
            if isinstance(made, SpecError):
                faults.append(made)
            elif key in here:
                faults.append(SpecError(f"two pictures are called {key!r}; rename one of them, in the list too"))
            else:
                here.add(key)
                self.pictures, self.kept = self.pictures | {key: made}, ""
        most = self.studio.settings.limits.pictures_bytes
        if sum(len(one.data) for one in self.pictures.values()) > most:
            self.pictures, self.kept = {}, ""
            faults.append(SpecError(f"the pictures take more than {most / 1e6:.0f} MB together; choose smaller ones"))
        if faults:
            more = f" (and {len(faults) - 1} more cannot be used)" if len(faults) > 1 else ""
            raise SpecError(f"{faults[0]}{more}")

    def _recall(self, keys: Mapping[str, str | None]) -> None:
        """Take what is kept since the form came before, but for what is to be left out.  Raises: SpecError."""
        texts = self.sent.texts
        if not (given := texts.get("kept", "")):
            return
        before = kept_pictures(self.studio, self.visitor, given, "what you chose as a picture")
        own = {key for key in keys.values() if key is not None}
        gone: set[str] = set()
        for what, key in keys.items():
            if texts.get(f"without_{what}"):
                gone |= {key} if key is not None else set(before) - own
        self.pictures = {key: picture for key, picture in before.items() if key not in gone}
        self.kept = given if self.pictures == before else ""

    def shown(self) -> dict[str, Any]:
        """What the form says of them when it is shown again: names by key, and where they are kept from now on."""
        if self.pictures and not self.kept:
            self.kept = keep_pictures(self.studio, self.visitor, self.pictures)
        return {"kept": self.kept, "names": {key: one.name or key for key, one in self.pictures.items()}}


def _texts(sent: Fields) -> dict[str, str]:
    """The texts of a form without names of pictures: here those come as files."""
    return {key: text for key, text in sent.texts.items() if key not in OF_ONE}


NOTHING: dict[str, Any] = {"kept": "", "names": {}}


def _page(request: Request, given: dict[str, str], *, status: int = 200, **shown: object) -> Response:
    context = {"checked": None, "problem": None, "chosen": NOTHING, "held_up": False} | CHOICES | shown
    return render(request, "issue.html.j2", status=status, given=given, **context)


def _event_page(
    request: Request, given: dict[str, str], people: str, *, status: int = 200, **shown: object
) -> Response:
    context: dict[str, object] = {"rows": [], "faults": 0, "notes": [], "sound": False, "problem": None}
    context |= {"chosen": NOTHING, "for_all": FOR_ALL} | CHOICES | shown
    return render(request, "event.html.j2", status=status, given=given, people=people, most=MOST_AT_AN_EVENT, **context)
