"""Errors for people and programs: one sentence, on a page or, under /api, as JSON."""

from __future__ import annotations

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from moireid.errors import MoireIdError
from moireid_studio.auth.guard import HEADERS
from moireid_studio.pages.render import render
from moireid_studio.problems import Refusal
from moireid_studio.store.database import is_away
from moireid_studio.studio import studio_of

#: Sentences for a status where the framework gives none.
WORDS = {
    404: ("not_found", "There is nothing at this address."),
    405: ("method", "This address does not take such a request."),
    400: ("bad_request", "This request cannot be read."),
}


def install(app: FastAPI) -> None:
    """Let the application answer every error in our words."""
    app.add_exception_handler(Refusal, _refused)
    app.add_exception_handler(MoireIdError, _ours)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(ClientDisconnect, _gone)
    app.add_exception_handler(Exception, _broken)


async def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, Refusal)
    return answer(request, error)


async def _ours(request: Request, error: Exception) -> Response:
    if is_away(error):
        text = "The database cannot be reached just now; try again in a moment."
        return answer(request, Refusal(503, "database", text, headers={"Retry-After": "10"}))
    return answer(request, Refusal(422, type(error).__name__, studio_of(request).sentence(error)))


async def _invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    told = [f"{'.'.join(map(str, one['loc'][1:])) or one['loc'][0]}: {one['msg']}" for one in error.errors()[:5]]
    return answer(request, Refusal(422, "fields", "The request cannot be used: " + "; ".join(told) + "."))


async def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    code, text = WORDS.get(error.status_code, ("refused", str(error.detail)))
    headers = dict(error.headers) if error.headers else None
    return answer(request, Refusal(error.status_code, code, text, headers=headers))


async def _broken(request: Request, _: Exception) -> Response:
    # The server raises the error again after this answer, so its log has the whole story.  The answer passes no guard.
    text = "Something went wrong inside moireid; the server's log says what."
    return answer(request, Refusal(500, "system", text, headers=HEADERS))


async def _gone(request: Request, _: Exception) -> Response:
    # Nobody reads this answer, but without one the server would log an error.
    return answer(request, Refusal(400, "broken_off", "The request was broken off; send it again."))


def answer(request: Request, error: Refusal) -> Response:
    """The answer to a request that was refused."""
    if request.url.path.startswith("/api/") or request.url.path == "/openapi.json":
        return JSONResponse({"code": error.code, "text": error.text}, error.status, headers=error.headers)
    template = "login.html.j2" if error.status == 401 else "problem.html.j2"
    response = render(request, template, status=error.status, problem=error)
    response.headers.update(error.headers or {})
    return response
