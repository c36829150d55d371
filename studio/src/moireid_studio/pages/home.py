"""The first page, help, and signing in and out."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Form, Request
from fastapi.responses import RedirectResponse, Response

from moireid_studio.auth.roles import COOKIE, anyone
from moireid_studio.auth.tokens import SESSION_H
from moireid_studio.forms import ShortRoute
from moireid_studio.pages.render import NAVIGATION, render
from moireid_studio.problems import Refusal
from moireid_studio.studio import studio_of

router = APIRouter(dependencies=[anyone], include_in_schema=False, route_class=ShortRoute)


@router.get("/")
def home(request: Request) -> Response:
    """What can be done here."""
    return render(request, "home.html.j2")


@router.get("/help")
def help_page(request: Request) -> Response:
    """How to film, what a verdict says, and the API."""
    limits = studio_of(request).settings.limits
    return render(request, "help.html.j2", limits=limits, here_url=str(request.base_url))


@router.get("/login")
def login_page(request: Request) -> Response:
    """Sign in with a token."""
    return render(request, "login.html.j2", problem=None)


@router.post("/login")
def login(request: Request, token: Annotated[str, Form(max_length=200)], back: Annotated[str, Form()] = "") -> Response:
    """Begin a session, whose cookie scripts cannot read, and requests from other sites do not carry."""
    session = studio_of(request).tokens.begin_session(token.strip())
    if session is None:
        text = "This token is unknown, has expired or was revoked; ask whoever runs this studio for another."
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
    """End the session: whoever has copied its cookie is signed out too."""
    studio_of(request).tokens.end_session(request.cookies.get(COOKIE, ""))
    answer = RedirectResponse("/", 303)
    answer.delete_cookie(COOKIE, path="/", httponly=True, samesite="strict")
    return answer
