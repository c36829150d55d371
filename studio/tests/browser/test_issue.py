"""The Issue and Enroll pages in a real browser: a badge is issued, downloaded, read back, and enrolled from a film.

Pictures of every page go to the folder that MOIREID_SCREENSHOTS names, or to the test's own.
Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import uvicorn

from kit.payloads import payload_for_name
from kit.webbing import OpenStudio, Visit, film_form
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
from moireid.verifier.session.capture import capture_as_built

BUILD = Build.typical(5)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Path:
    """A film of a badge as built: the sheet off its place, turned, and of another pitch."""
    path = tmp_path_factory.mktemp("capture") / "capture.mp4"
    motion = motion_named("sway", distance_mm=1000.0, seed=3)
    film(Scene(ada, BUILD, camera_named("phone")), motion, path, frames=60, fps=15, seed=3)
    return path


@pytest.fixture(scope="module")
def measured(ada: Badge, capture: Path) -> AsBuilt:
    """What the command would measure."""
    return capture_as_built([capture], ada)


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio(auth=False, work=False)


@pytest.fixture(scope="module")
def site(visit: Visit) -> Iterator[str]:
    """The address of a studio that is served."""
    server = uvicorn.Server(uvicorn.Config(visit.app, port=0, log_level="warning", timeout_graceful_shutdown=2))
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.05)
    yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    server.should_exit = True
    thread.join()


@pytest.mark.slow
def test_the_api_measures_and_keeps_only_when_it_is_told(
    visit: Visit, site: str, ada: Badge, capture: Path, measured: AsBuilt
) -> None:
    """Catches: figures that are kept unasked or of another film, jobs of one badge kept for another, films kept."""
    other = design_badge(Order("Somebody Else", lens="50lpi"), payload_for_name("Somebody Else"))
    for badge in (ada, other):
        visit.studio.registry.enroll(badge)
    with httpx.Client(base_url=f"{site}/api/badges", timeout=60) as client:

        def begin(badge: Badge, film: Path) -> dict[str, Any]:
            begun = client.post(f"/{badge.id}/captures", **film_form(film))
            assert begun.status_code == 202
            while (report := client.get(f"/jobs/{begun.json()['id']}").json())["state"] not in ("done", "failed"):
                time.sleep(0.2)
            return report

        report = begin(ada, capture)
        assert report["result"]["as_built"] == json.loads(measured.to_json())
        assert client.post(f"/{other.id}/captures/{report['id']}/keep").status_code == 404
        kept = client.post(f"/{ada.id}/captures/{report['id']}/keep").json()
        assert kept["as_built"] == report["result"]["as_built"] and kept["id"] == ada.id
        events = client.get(f"/jobs/{report['id']}/events").text
        assert events.startswith("event: end\ndata: ") and json.loads(events.split("data: ")[1])["state"] == "done"
        wrong = begin(other, capture)
        assert wrong["state"] == "failed" and "Film the badge again" in wrong["problem"]["text"]
        assert client.post(f"/{other.id}/captures/{wrong['id']}/keep").status_code == 409
        assert client.post(f"/{'0' * 16}/captures", **film_form(capture)).status_code == 404
        assert client.post(f"/{ada.id}/captures", **film_form(b"#EXTM3U\nfile:///etc/passwd")).status_code == 415
