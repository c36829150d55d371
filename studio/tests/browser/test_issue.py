"""The Issue and Enroll pages in a real browser: a badge is issued, downloaded, read back, and enrolled from a film.

Pictures of every page go to the folder that MOIREID_SCREENSHOTS names, or to the test's own.
Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import json
import math
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import uvicorn
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, sync_playwright

from kit.payloads import payload_for_name
from kit.programs import needs
from kit.webbing import OpenStudio, Visit, film_form
from moireid.artwork.content import with_lines
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
from moireid.verifier.session.capture import capture_as_built
from moireid_studio.jobs.claims import find_claimed
from moireid_studio.pages.enroll import measured_words

BUILD = Build.typical(5)
LOGO = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 60 20"><path d="M0 0h60v20H0z" fill="#ff00ff"/></svg>'
WIDE, PHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}


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


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = needs("chromium")
    with sync_playwright() as playwright:
        camera = ["--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream"]
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *camera])
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser, site: str) -> Iterator[Page]:
    """A page at the studio's address; a script that fails, or a style that the policy refuses, fails the test."""
    context = browser.new_context(base_url=site, viewport=WIDE)
    page = context.new_page()
    said: list[str] = []
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("console", lambda message: said.append(message.text) if "Policy" in message.text else None)
    yield page
    context.close()
    assert said == []


Look = Callable[[str], None]


@pytest.fixture
def look(page: Page, tmp_path: Path) -> Look:
    """Keeps pictures of a page, wide and on a phone, and holds it against axe and against its own width."""
    pictures = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
    pictures.mkdir(parents=True, exist_ok=True)
    return lambda name: _look(page, pictures, name)


def _look(page: Page, pictures: Path, name: str) -> None:
    for size, tag in ((PHONE, "phone"), (WIDE, "wide")):
        page.set_viewport_size(size)
        page.screenshot(path=pictures / f"{name}-{tag}.png", full_page=True)
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"], f"{name} is wider than {tag}"
    found = Axe().run(page).response["violations"]
    assert [(one["id"], one["help"]) for one in found if one["impact"] in ("serious", "critical")] == []


@pytest.mark.slow
def test_what_is_told_of_a_capture_is_how_the_badge_was_built(ada: Badge, measured: AsBuilt) -> None:
    """Catches: a twist or an offset of the wrong sign or unit, half a pitch forgotten, errors that are none."""
    beat, gain, twist, offset = measured_words(measured, ada)
    assert twist.value == pytest.approx(math.degrees(BUILD.twist_rad), abs=2 * twist.error) and twist.error < 0.01
    assert offset.value == pytest.approx(BUILD.lens_offset_mm, abs=2 * offset.error) and offset.error < 0.01
    assert gain.value - gain.error < 1 < gain.value + gain.error and gain.within
    code = ada.gratings[0].code
    assert code is not None
    lens, page = ada.lens.pitch_mm * BUILD.lens_scale, ada.gratings[0].cells[code.reference_cell].pitch_mm
    # In page units, as all that a film shows.
    built = 1 / abs(1 / page - BUILD.print_scale / lens)
    assert beat.value == pytest.approx(built, abs=0.1) and beat.within and twist.within
    assert "anticlockwise" in twist.text and "to its right" in offset.text


@pytest.mark.slow
def test_a_badge_with_all_that_it_can_wear_is_seen_before_and_after_it_is_made(page: Page, look: Look) -> None:
    """Catches: no picture of what is ordered; choices that are lost."""
    page.goto("/issue")
    page.get_by_label("Name", exact=True).fill("Nellie Bly")
    page.get_by_label("Lines below the name").fill("Reporter\nExample News")
    page.get_by_role("radio", name="A7", exact=False).check()
    page.get_by_role("radio", name="Conference").check()
    page.locator("#colour").fill("#0000ff")
    page.locator("#mount").select_option("none")
    page.locator("#logo").set_input_files({"name": "logo.svg", "mimeType": "image/svg+xml", "buffer": LOGO})
    page.get_by_role("button", name="Check").click()
    seen = page.get_by_role("img", name="The badge seen straight on", exact=False)
    assert seen.evaluate("picture => picture.decode().then(() => picture.naturalWidth)") > 100
    look("issue-worn-checked")
    page.get_by_role("button", name="Issue and make the package").click()
    made = page.get_by_role("img", name="The finished badge as it is worn")
    made.wait_for(timeout=90_000)
    assert made.evaluate("picture => picture.decode().then(() => picture.naturalWidth)") > 100
    look("issue-worn-issued")


def test_namesakes_are_offered_by_the_line_below_their_name(page: Page, visit: Visit) -> None:
    """Catches: one suggestion for two people, ids in the place of lines, a suggestion that the claim does not take."""
    for line in ("Reporter", "Editor"):
        badge = design_badge(Order("Ana Silva", lens="50lpi"), payload_for_name(f"Ana Silva {line}"))
        visit.studio.registry.enroll(with_lines(badge, [line]))
    for address in ("/verify", "/live", "/call", "/links", "/enroll"):
        page.goto(address)
        with page.expect_response("**/api/registry?*search=Ana"):
            page.locator("#claim").fill("Ana")
        page.locator("#claim-claims option").first.wait_for(state="attached")
        offered = page.locator("#claim-claims option").evaluate_all("all => all.map((one) => one.value)")
        assert sorted(offered) == ["Ana Silva, Editor", "Ana Silva, Reporter"], address
    for claim in offered:
        assert find_claimed(visit.studio.registry, claim, ids=False).badge.name == "Ana Silva"


@pytest.mark.slow
def test_a_capture_can_be_recorded_here(page: Page, look: Look) -> None:
    """Catches: a recording that is not handed to the form, a camera left on, a form that sends no film."""
    page.goto("/enroll")
    page.get_by_label("Whose badge").fill("nobody")
    page.get_by_role("button", name="Measure").click()
    assert page.url.endswith("/enroll") and page.evaluate("!document.querySelector('#video').validity.valid")
    page.get_by_role("button", name="Record with this device's camera").click()
    page.get_by_role("button", name="Stop, and use it").wait_for()
    page.wait_for_timeout(1500)
    look("enroll-recording")
    page.get_by_role("button", name="Stop, and use it").click()
    page.get_by_text("Recorded").wait_for()
    assert page.evaluate("document.querySelector('#video').files[0].size") > 1000
    assert page.evaluate("document.querySelector('video').srcObject") is None
    page.get_by_role("button", name="Measure").click()
    assert "nobody" in (page.get_by_role("alert").text_content() or "")
    assert "sqlite" not in page.content()


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
