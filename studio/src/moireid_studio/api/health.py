"""For those who look after the studio: is it up, is it ready for work, and its figures."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel

from moireid import __version__
from moireid_studio.auth.guard import anyone, require
from moireid_studio.studio import studio_of

#: Not part of the API for programs: probes and Prometheus know these addresses by custom.
router = APIRouter(include_in_schema=False)


class Readiness(BaseModel):
    """Whether new work may come, and of each thing that is needed whether it answers."""

    ready: bool
    needs: dict[str, bool]


@router.get("/healthz", dependencies=[anyone])
async def alive() -> dict[str, str]:
    """Whether the process answers at all; it asks nothing else, so that it is not restarted for another's fault."""
    return {"status": "ok", "moireid": __version__}


@router.get("/readyz", dependencies=[anyone], responses={503: {"model": Readiness, "description": "not ready"}})
def ready(request: Request) -> Response:
    """Whether this studio can take work now: registry, database and storage answer, and it is not being stopped."""
    needs = studio_of(request).needs()
    answer = Readiness(ready=all(needs.values()), needs=needs)
    return JSONResponse(answer.model_dump(), 200 if answer.ready else 503)


@router.get(
    "/metrics",
    dependencies=[require("monitor")],
    response_class=Response,
    responses={200: {"description": "figures in Prometheus' text format", "content": {"text/plain": {}}}},
)
def metrics(request: Request) -> Response:
    """Figures for Prometheus; they name no person, film or token."""
    return Response(studio_of(request).metrics.text(), media_type="text/plain; version=0.0.4; charset=utf-8")
