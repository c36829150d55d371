"""The studio's pages in a real browser, as people use them.  Each test names the wrong implementation it catches.

Pictures of every page go to the folder that MOIREID_SCREENSHOTS names, or to the test's own.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

from kit.payloads import payload_for_name
from kit.programs import needs
from kit.webbing import badge_film, tiny_film
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.registry import open_registry
from moireid_studio.auth.tokens import Tokens

#: A browser walks through whole checks of films.
pytestmark = pytest.mark.slow

PHONE, DESK = {"width": 375, "height": 740}, {"width": 1200, "height": 800}
#: A film of 8 s takes some seconds, and a busy machine many times that.
PATIENCE_MS = 100_000
expect.set_options(timeout=PATIENCE_MS)
#: The widths of all pictures, those too that the browser would load later.
LOADED = """Promise.all([...document.images].map(async (image) => {
    image.loading = "eager"; await image.decode(); return image.naturalWidth; }))"""


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Iterator[tuple[str, str]]:
    """The address of a studio that was started by its command, and a token of an admin."""
    needs("chromium")
    folder = tmp_path_factory.mktemp("served")
    environment = os.environ | {"MOIREID_KEYS": str(folder / "keys")}
    url = f"sqlite:///{folder}/registry.sqlite3"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOIREID_KEYS", environment["MOIREID_KEYS"])
        with open_registry(url, create=True) as registry:
            registry.enroll(ada)
    tokens = Tokens(folder / "studio")
    secret, _ = tokens.create("admin")
    tokens.close()
    code = "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"
    command = [sys.executable, "-c", code, "serve", "--port", "0", "--registry", url, "--data", str(folder / "studio")]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as server:
        assert server.stderr is not None
        said = server.stderr.readline()
        assert "the studio is at http://" in said, said
        yield said.split()[4].rstrip("/"), secret
        server.send_signal(signal.SIGINT)
        assert server.wait(30) == 0
    assert not list((folder / "studio").rglob("film.*"))


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = needs("chromium")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield made
        made.close()


class Visitor:
    """A person at a page, who looks at it at both widths."""

    def __init__(self, context: BrowserContext, home: str, pictures: Path) -> None:
        context.set_default_timeout(PATIENCE_MS)
        self.page: Page = context.new_page()
        self.home, self.pictures = home, pictures
        self.faults: list[str] = []
        self.page.on("console", lambda said: self.faults.append(said.text) if said.type == "error" else None)
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))

    def go(self, path: str) -> None:
        self.page.goto(self.home + path)

    def look(self, name: str) -> None:
        """Keep pictures of the page, and see that nothing is wrong with it for anybody."""
        for shape, size in (("desk", DESK), ("phone", PHONE)):
            self.page.set_viewport_size(size)
            self.page.screenshot(path=self.pictures / f"{name}-{shape}.png", full_page=True)
            wide = self.page.evaluate("document.documentElement.scrollWidth")
            assert wide <= size["width"], f"{name} is {wide} px wide on a {shape}"
            found = Axe().run(self.page).response["violations"]
            grave = [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in ("serious", "critical")]
            assert grave == [], f"{name} on a {shape}"
        self.page.set_viewport_size(DESK)
        assert self.faults == [], f"{name}: the console says so"


@pytest.fixture
def visitor(served: tuple[str, str], browser: Browser, pictures: Path) -> Iterator[Visitor]:
    home, secret = served
    context = browser.new_context(viewport=DESK, accept_downloads=True)
    guest = Visitor(context, home, pictures)
    guest.go("/login")
    guest.page.get_by_label("Token").fill(secret)
    guest.page.get_by_role("button", name="Sign in").click()
    expect(guest.page.get_by_role("button", name="Sign out")).to_be_visible()
    yield guest
    context.close()


def test_a_genuine_and_a_forged_film(visitor: Visitor, films: Path, tmp_path: Path) -> None:
    """Catches: a page with another verdict than the film's, plots that the policy blocks, a form that needs a mouse."""
    page = visitor.page
    visitor.go("/verify")
    visitor.look("verify")
    broken = "The fringes do not follow the law: they go the other way than they should"
    for film, headline in (
        ("genuine_1.0m.mp4", "Genuine; no person was claimed"),
        ("forged_reversed_1.0m.mp4", broken),
    ):
        visitor.go("/verify")
        page.get_by_label("The film", exact=True).set_input_files(films / film)
        page.get_by_label("or the badge's own file").set_input_files(films / "badge.json")
        page.get_by_role("button", name="Verify").focus()
        page.keyboard.press("Enter")
        page.wait_for_url(re.compile("/verify/[0-9a-f]{32}$"))
        if headline != broken:
            expect(page.get_by_role("status")).to_contain_text("frames")
            visitor.look("waiting")
        expect(page.get_by_role("heading", level=1)).to_contain_text(headline)
        widths = page.evaluate(LOADED)
        assert len(widths) >= 4 and min(widths) > 0
        visitor.look("verdict" if headline != broken else "verdict-broken")
        page.get_by_text("For experts").click()
        page.emulate_media(color_scheme="dark")
        visitor.look("verdict-open-dark" if headline != broken else "verdict-broken-open-dark")
        page.emulate_media(color_scheme="light")
    with page.expect_download() as coming:
        page.get_by_role("link", name="Report (one page)").click()
    kept = Path(coming.value.path()).read_text()
    assert broken in kept and "forged_reversed_1.0m.mp4" in kept


def test_without_script_the_same(served: tuple[str, str], browser: Browser, films: Path, ada: Badge) -> None:
    """Catches: a form or a page of progress that needs script."""
    home, secret = served
    context = browser.new_context(java_script_enabled=False)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.goto(f"{home}/verify")
    page.get_by_label("Token").fill(secret)
    page.get_by_role("button", name="Sign in").click()
    page.wait_for_url("**/verify")
    page.get_by_label("The film", exact=True).set_input_files(films / "forged_drift_1.0m.mp4")
    page.get_by_label("or the badge's own file").set_input_files(films / "badge.json")
    page.get_by_role("button", name="Verify").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("do not follow the law", timeout=PATIENCE_MS)
    context.close()


@pytest.fixture(scope="module")
def shown(ada: Badge, films: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Films by what is found in them: a badge that is enrolled, one that is not, and none."""
    folder = tmp_path_factory.mktemp("shown")
    grace = design_badge(Order("Grace Hopper", lens="50lpi"), payload_for_name("Grace Hopper"))
    return {
        "✓ Genuine, and Ada Lovelace's": badge_film(ada, folder / "ada.mp4"),
        "✗ Genuine, but held by no one in this registry": badge_film(grace, folder / "grace.mp4"),
        "? Cannot tell: the film is too short": tiny_film(films / "genuine_1.0m.mp4", folder / "other.mp4"),
    }
