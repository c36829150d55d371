"""The application: which routes there are, and what a request passes before them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib import resources

from fastapi import APIRouter, FastAPI
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import Response

from moireid import __version__
from moireid.errors import RegistryError
from moireid.verifier.report.report_page import style as report_style
from moireid_studio.api import films as api
from moireid_studio.api import health as health_api
from moireid_studio.api import issue_api, registry_api, work_api
from moireid_studio.api.schema import describe
from moireid_studio.auth.guard import Guard, anyone
from moireid_studio.http.logs import note_request
from moireid_studio.http.metrics import Gauge, RequestMetrics
from moireid_studio.live import link_routes
from moireid_studio.live import routes as live
from moireid_studio.pages import enroll as enroll_pages
from moireid_studio.pages import home as home_pages
from moireid_studio.pages import issue_pages, registry_pages, verify
from moireid_studio.settings import Settings
from moireid_studio.studio import Studio

#: Every file of routes, in the order of the navigation.  A new one is added here.
ROUTERS: tuple[APIRouter, ...] = (
    home_pages.router,
    issue_pages.router,
    enroll_pages.router,
    verify.router,
    registry_pages.router,
    api.router,
    issue_api.router,
    registry_api.router,
    health_api.router,
    work_api.router,
    live.router,
    live.enroll_router,
    link_routes.router,
    link_routes.check_router,
)
#: Time between two looks for links that are to be removed, s.
FORGET_S = 3600.0
KINDS = {".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml", ".webp": "image/webp"}


async def _forget(studio: Studio) -> None:
    """Remove old links now and then: on a quiet studio nothing else would."""
    while True:
        await asyncio.sleep(FORGET_S)
        try:
            await run_in_threadpool(studio.links.remove_old)
        except (RegistryError, OSError) as error:
            logging.getLogger(__name__).error("%s", error)


def create_app(settings: Settings) -> FastAPI:
    """The studio as an ASGI application; it holds its registry open until it is shut down.

    Raises: RegistryError where the registry that is named is absent, or the studio's folder cannot be used.
    """
    studio = Studio(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await run_in_threadpool(studio.start)
        forgetting = asyncio.create_task(_forget(studio))
        try:
            yield
        finally:
            forgetting.cancel()
            await run_in_threadpool(studio.stop)
            studio.close()

    # The framework's own documentation pages load scripts from other sites.
    app = FastAPI(
        title="moireid studio",
        version=__version__,
        docs_url=None,
        redoc_url=None,
        lifespan=lifespan,
        # Otherwise it would redirect to any Host that a request names.
        redirect_slashes=False,
    )
    app.state.studio = studio
    studio.metrics.watch(_gauges(studio))
    app.add_middleware(Guard, loopback_only=not settings.auth)
    app.add_middleware(RequestMetrics, metrics=studio.metrics, note=note_request)
    verify.install(app)
    for router in (*ROUTERS, _static()):
        # Each with its own prefix and rules already; in one flat list, so that all of them can be checked.
        app.router.routes.extend(router.routes)
    describe(app)
    return app


def _gauges(studio: Studio) -> list[Gauge]:
    """What is asked for when the figures are read."""
    ledger = studio.jobs.ledger
    return [
        ("moireid_jobs", "Jobs by state.", "state", ledger.counts),
        ("moireid_stored_bytes", "Bytes of films that are stored.", "", lambda: {"": sum(ledger.stored().values())}),
        ("moireid_live_sessions", "Live checks that go on.", "", lambda: {"": studio.live_sessions.total()}),
    ]


def _static() -> APIRouter:
    """The files of `static/`, each by its name: read once, and no path is ever made of what a visitor sends."""
    router = APIRouter(dependencies=[anyone], include_in_schema=False)
    for entry in resources.files("moireid_studio").joinpath("static").iterdir():
        kind = KINDS.get("." + entry.name.rpartition(".")[2])
        if kind is not None:
            _one_file(router, entry.name, entry.read_bytes(), kind)
    # The style of a verdict is that of the report's own page.
    _one_file(router, "report.css", report_style().encode(), KINDS[".css"])
    return router


def _one_file(router: APIRouter, name: str, content: bytes, kind: str) -> None:
    @router.get(f"/static/{name}")
    def file() -> Response:
        return Response(content, media_type=kind, headers={"Cache-Control": "max-age=300"})
