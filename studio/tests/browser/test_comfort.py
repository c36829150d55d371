"""The studio as tired people use it: on a phone, with a poor camera, with many films, and with every choice once.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from kit.browsing import look, served
from kit.programs import needs
from moireid.badge import Badge
from moireid_studio.settings import Limits

#: A browser walks through whole pages.
pytestmark = pytest.mark.slow

#: Two cameras that give few pictures.
CAMERAS = ("--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream=device-count=2,fps=5")
WIDE, PHONE = {"width": 1280, "height": 800}, {"width": 375, "height": 740}


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Iterator[str]:
    with served(tmp_path_factory.mktemp("comfort"), ada, limits=Limits(upload_bytes=1 << 20)) as (url, _):
        yield url


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = needs("chromium")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *CAMERAS])
        yield made
        made.close()


@pytest.fixture
def page(browser: Browser, home: str) -> Iterator[Page]:
    """A page at the studio's address; a script that fails fails the test."""
    context = browser.new_context(base_url=home, viewport=WIDE)
    context.set_default_timeout(60_000)
    page, said = context.new_page(), list[str]()
    page.on("pageerror", lambda error: said.append(str(error)))
    yield page
    context.close()
    assert said == []


@pytest.mark.parametrize("path", ["/", "/issue", "/issue/event", "/enroll", "/verify", "/live", "/call"])
def test_pages_at_every_width(page: Page, pictures: Path, path: str) -> None:
    """Catches: a page that sticks out to the side, also of a narrow phone; what axe finds, in the open menu too."""
    name = path.strip("/").replace("/", "-") or "home"
    page.goto(path)
    page.set_viewport_size({"width": 360, "height": 740})
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    look(page, pictures, name)
    page.set_viewport_size(PHONE)
    page.get_by_role("button", name="Menu").click()
    look(page, pictures, f"{name}-menu", shapes=())


def test_issue_is_one_screen_to_check(page: Page) -> None:
    """Catches: choices that few need between the name and *Check* on a phone."""
    page.set_viewport_size(PHONE)
    page.goto("/issue")
    box = page.get_by_role("button", name="Check", exact=True).bounding_box()
    assert box is not None and box["y"] + box["height"] <= PHONE["height"]


@pytest.mark.parametrize("path", ["/registry", "/registry/audit", "/links", "/help"])
def test_other_pages_at_every_width(page: Page, pictures: Path, path: str) -> None:
    """Catches: as above."""
    test_pages_at_every_width(page, pictures, path)
