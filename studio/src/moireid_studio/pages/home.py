"""The first page, help, signing in and out, and `render`, which makes every page from its template.

Jinja2 escapes all values, and fails at a name that has no value.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import jinja2
from fastapi import APIRouter, Form, Request
from fastapi.responses import HTMLResponse, RedirectResponse, Response

from moireid import __version__
from moireid.errors import MoireIdError
from moireid.verifier.report.report_page import template as report_template
from moireid_studio.auth.guard import COOKIE, anyone, visitor_of
from moireid_studio.auth.tokens import SESSION_H, Role
from moireid_studio.forms import ShortRoute
from moireid_studio.http.addresses import address_for
from moireid_studio.problems import Refusal, plain
from moireid_studio.store.database import is_away
from moireid_studio.studio import studio_of


@dataclass(frozen=True)
class Place:
    """An entry of the navigation, shown to the roles that may open it; without roles, to everyone.

    words: what it is for; door: what the first page calls it, where it is one of the large doors there.
    """

    path: str
    label: str
    words: str
    roles: tuple[Role, ...] = ()
    door: str = ""


NAVIGATION = (
    Place(
        "/issue",
        "Issue",
        "Design a badge for a person, or for everyone at an event, and download what to print.",
        ("issuer",),
        "Issue a badge",
    ),
    Place(
        "/enroll",
        "Enroll",
        "Film a finished badge once, so that a copy built anew can be recognised.",
        ("issuer",),
        "Enroll a badge",
    ),
    Place(
        "/verify",
        "Verify",
        "Drop a film, name the person, and read the verdict with its reasons.",
        ("verifier",),
        "Verify a film",
    ),
    Place(
        "/live",
        "Live",
        "Let a person move the badge before the camera, and get a verdict within seconds.",
        ("verifier",),
    ),
    Place(
        "/call",
        "Call",
        "Is the person in a video call the one they say? Share the call with this page, and read sentences aloud.",
        ("verifier",),
        "Check a call",
    ),
    Place(
        "/links",
        "Links",
        "Send someone a link that works once: they follow prompts before their own camera, and you read the verdict.",
        ("verifier",),
    ),
    Place(
        "/registry", "Registry", "Look up who holds which badge, revoke one, and audit the log.", ("issuer", "verifier")
    ),
    Place("/help", "Help", "How to film, what a verdict says and does not say, and the API."),
)

_environment = jinja2.Environment(
    # The parts of a verdict are those of the report's own page.
    loader=jinja2.ChoiceLoader([jinja2.PackageLoader("moireid_studio"), jinja2.FunctionLoader(report_template)]),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
#: Sentences of the library about what was not made.
_environment.filters["plain"] = plain


def render(request: Request, template: str, *, status: int = 200, **context: Any) -> HTMLResponse:
    """The page that `templates/TEMPLATE` makes of `context`; base.html.j2 also gets navigation and visitor.

    While the database is away, a page is as for one who has not signed in: it may be the page that says so.
    """
    try:
        visitor = visitor_of(request)
    except MoireIdError as error:
        if not is_away(error):
            raise
        visitor = None
    path = request.url.path
    shown = [place for place in NAVIGATION if not place.roles or (visitor is not None and visitor.may(*place.roles))]
    page = _environment.get_template(template).render(
        navigation=shown,
        here=path,
        visitor=visitor,
        auth=studio_of(request).settings.auth,
        version=__version__,
        **context,
    )
    return HTMLResponse(page, status)


router = APIRouter(dependencies=[anyone], include_in_schema=False, route_class=ShortRoute)


@router.get("/")
def home(request: Request) -> Response:
    """What can be done here."""
    return render(request, "home.html.j2")


@router.get("/help")
def help_page(request: Request) -> Response:
    """How to film, what a verdict says, and the API."""
    limits = studio_of(request).settings.limits
    return render(request, "help.html.j2", limits=limits, here_url=address_for(request).url)


@router.get("/login")
def login_page(request: Request) -> Response:
    """Sign in with a token."""
    return render(request, "login.html.j2", problem=None)


@router.post("/login")
def login(request: Request, token: Annotated[str, Form(max_length=200)], back: Annotated[str, Form()] = "") -> Response:
    """Begin a session, whose cookie scripts cannot read, and requests from other sites do not carry."""
    session = studio_of(request).tokens.begin_session(token.strip())
    if session is None:
        text = "This token is unknown, has expired or was revoked; ask the operator of this studio for another."
        raise Refusal(401, "token", text)
    # Only known places are allowed, because the visitor's request names where to go next.
    known = {place.path for place in NAVIGATION}
    answer = RedirectResponse(back if back in known else "/", 303)
    answer.set_cookie(
        COOKIE,
        session,
        max_age=int(SESSION_H * 3600),
        path="/",
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return answer


@router.post("/logout")
def logout(request: Request) -> Response:
    """End the session, also for anyone who has copied its cookie."""
    studio_of(request).tokens.end_session(request.cookies.get(COOKIE, ""))
    answer = RedirectResponse("/", 303)
    answer.delete_cookie(COOKIE, path="/", httponly=True, samesite="strict")
    return answer
