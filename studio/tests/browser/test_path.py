"""A stranger's way from the first page to a printed page, an enrolment and a verdict, counted in clicks.

The test says what it catches.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pypdfium2 as pdfium
import pytest
from playwright.sync_api import Browser, Locator, Page, expect, sync_playwright

from kit.browsing import look, served
from kit.programs import needs
from moireid.badge import Badge, load_badge
from moireid.simulate.build import Build
from moireid.simulate.cameras import camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Scene

pytestmark = pytest.mark.slow

MOST_CLICKS = 12
#: As people build it.
BUILD = Build.typical(5)
#: A whole package with its mount, on a machine that others use too.
PATIENCE_MS = 240_000


class Visitor:
    """A person with a mouse, whose clicks are counted; typing is not, choosing a file is one."""

    def __init__(self, page: Page) -> None:
        self.page, self.clicks = page, 0

    def click(self, what: Locator) -> None:
        self.clicks += 1
        what.click()

    def choose(self, field: Locator, path: Path) -> None:
        self.clicks += 1
        field.set_input_files(path)


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    """The first page of a studio in which no one is enrolled."""
    program = needs("chromium")
    with served(tmp_path) as (home, _), sync_playwright() as playwright:
        drawn = ["--enable-unsafe-swiftshader", "--use-angle=swiftshader"]
        browser: Browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *drawn])
        page = browser.new_page(base_url=home, viewport={"width": 1280, "height": 900})
        page.set_default_timeout(PATIENCE_MS)
        page.goto("/")
        yield page
        browser.close()


def filmed(badge: Badge, path: Path, *, seed: int) -> Path:
    """A film of the badge as built, swayed before a phone."""
    motion = motion_named("sway", distance_mm=1000.0, seed=seed)
    film(Scene(badge, BUILD, camera_named("phone")), motion, path, frames=120, fps=15, seed=seed)
    return path


def test_from_the_first_page_to_a_verdict_in_at_most_twelve_clicks(page: Page, tmp_path: Path) -> None:
    """Catches: a way with detours; a page that does not lead to the next step; a studio in which the last step refuses
    what the first one made.
    """
    pictures = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
    someone = Visitor(page)
    someone.click(page.get_by_role("link", name="Issue a badge"))
    page.get_by_label("Name", exact=True).fill("Bea Newcomer")
    someone.click(page.get_by_role("button", name="Issue and make the package"))
    package = page.get_by_role("link", name="Download the package")
    expect(package).to_be_visible(timeout=PATIENCE_MS)
    expect(page.locator("[data-status]")).to_contain_text("parts are shown", timeout=60_000)
    look(page, pictures, "path-issued")
    with page.expect_download() as coming:
        someone.click(package)
    with zipfile.ZipFile(coming.value.path()) as archive:
        archive.extractall(tmp_path)
    (folder,) = tmp_path.glob("badge-*")
    with pdfium.PdfDocument(folder / "badge.pdf") as printed:
        assert "Bea Newcomer" in printed[0].get_textpage().get_text_bounded()
    badge = load_badge(folder / "badge.json")

    someone.click(page.get_by_role("link", name="Enroll it"))
    someone.choose(page.get_by_label("A film of it"), filmed(badge, tmp_path / "capture.mp4", seed=3))
    someone.click(page.get_by_role("button", name="Measure"))
    someone.click(page.get_by_role("button", name="Keep these figures"))
    expect(page.get_by_role("status").get_by_text("can be recognised")).to_be_visible(timeout=PATIENCE_MS)

    someone.click(page.locator(".top nav").get_by_role("link", name="Verify"))
    someone.choose(page.get_by_label("The film", exact=True), filmed(badge, tmp_path / "film.mp4", seed=5))
    page.get_by_label("Name or id").fill("Bea Newcomer")
    someone.click(page.get_by_role("button", name="Verify"))
    expect(page.get_by_role("heading", level=1)).to_contain_text("Genuine, and Bea Newcomer's", timeout=PATIENCE_MS)
    look(page, pictures, "path-verdict")
    # Ten today; a step more is a detour to look into.
    assert someone.clicks == 10 <= MOST_CLICKS
