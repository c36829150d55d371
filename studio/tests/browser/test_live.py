"""The live check in a real browser, whose camera is fed from a film file.  Each test names what it would catch."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import pytest
import uvicorn
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect, sync_playwright

from kit.browsing import settled
from kit.programs import needs
from moireid.badge import Badge
from moireid.registry import open_registry
from moireid_lab.bench.live import FACE_MM, answer, frames, portrait
from moireid_studio.app import create_app
from moireid_studio.challenge.challenge import Prompt
from moireid_studio.challenge.session import READY_S
from moireid_studio.settings import Settings

#: A session lasts as long as its film.
pytestmark = [pytest.mark.slow, pytest.mark.alone]

#: What the film's person does, and when it was asked for in the film; the film runs over and over.
FILMED = (Prompt("left", 4.6), Prompt("face", 7.9), Prompt("right", 12.3))
LENGTH_S, FPS = 15.6, 30.0
#: The challenge is started so far into the film; its first prompt then comes about when the film's does.
STARTED_S = 2.7
MISSED = "✗ The prompts were not followed"


@dataclass
class Studio:
    """A running studio, and the prompts that its next challenge will have: moves, at the film's times.

    lit_s: when the light in the film's corner was seen, by the clock of this machine.
    """

    url: str
    moves: list[str] = field(default_factory=list)
    lit_s: float = 0.0

    def prompts(self, start_s: float) -> list[Prompt]:
        # The film went on while a slow machine began the challenge.
        from_film = start_s - STARTED_S - READY_S - (time.time() - self.lit_s)
        return [Prompt(move, from_film + one.at_s) for move, one in zip(self.moves, FILMED, strict=False)]


@pytest.fixture(scope="module")
def camera_film(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Path:
    """What the camera sees: a person who follows `FILMED`, as pictures one after another."""
    path = tmp_path_factory.mktemp("camera") / "person.mjpeg"
    course = answer(FILMED, FACE_MM, reaction_s=0.7)
    with path.open("wb") as out:
        for number, picture in enumerate(frames(ada, portrait(), course, length_s=LENGTH_S, fps=FPS)):
            small = cv2.resize(picture, (960, 540), interpolation=cv2.INTER_AREA)
            # A light in the corner shows the test where the film is: a busy machine plays it slower.
            small[-40:, :40] = 255 if 0 <= number / FPS - STARTED_S < 0.2 else 0
            out.write(cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 92])[1].tobytes())
    return path


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Iterator[Studio]:
    folder = tmp_path_factory.mktemp("studio")
    url = f"sqlite:///{folder / 'people.sqlite3'}"
    keys = pytest.MonkeyPatch()
    keys.setenv("MOIREID_KEYS", str(folder / "keys"))
    with open_registry(url, create=True) as registry:
        registry.enroll(ada)
    app = create_app(Settings(url, folder / "data", auth=False))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    running = Studio(f"http://127.0.0.1:{port}")
    app.state.live_prompts = running.prompts
    server = uvicorn.Server(uvicorn.Config(app, port=port, log_level="warning"))
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.02)
    yield running
    server.should_exit = True
    thread.join(10)
    keys.undo()


def look(page: Page, pictures: Path, name: str) -> None:
    """Take pictures of the page at both widths, and let axe look at it; nothing may stick out to the side."""
    for shape, size in {"phone": (375, 740), "desk": (1200, 800)}.items():
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.screenshot(path=pictures / f"live-{name}-{shape}.png", full_page=True)
        assert page.evaluate("document.documentElement.scrollWidth") <= size[0], (name, shape)
    found = Axe().run(page).response["violations"]
    assert [one["id"] for one in found if one["impact"] in ("serious", "critical")] == []


@pytest.fixture(scope="module")
def page(camera_film: Path) -> Iterator[Page]:
    chromium = needs("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium,
            args=[
                "--no-sandbox",
                "--use-fake-device-for-media-stream",
                "--use-fake-ui-for-media-stream",
                f"--use-file-for-fake-video-capture={camera_film}",
            ],
        )
        yield browser.new_page(viewport={"width": 1200, "height": 900})
        browser.close()


def challenged(page: Page, studio: Studio, moves: list[str], pictures: Path) -> str:
    """Go through an enrolment by a live check with these prompts; the title of what was measured, or the verdict."""
    studio.moves = moves
    page.goto(f"{studio.url}/live/enroll")
    page.get_by_label("Whose badge").fill("Ada Lovelace")
    page.get_by_role("button", name="Start the camera").click()
    start = page.get_by_role("button", name="Start the challenge")
    expect(start).to_be_enabled(timeout=60_000)
    studio.lit_s = page.evaluate(
        """() => new Promise((done) => {
            const video = document.querySelector("video"), canvas = document.createElement("canvas");
            canvas.width = canvas.height = 1;
            const look = canvas.getContext("2d", { willReadFrequently: true });
            const timer = setInterval(() => {
                look.drawImage(video, 8, video.videoHeight - 20, 8, 8, 0, 0, 1, 1);
                if (look.getImageData(0, 0, 1, 1).data[0] > 128) { clearInterval(timer); done(Date.now() / 1000); }
            }, 20);
        })"""
    )
    start.click()
    expect(page.locator("#count")).to_be_visible(timeout=60_000)
    look(page, pictures, "prompt")
    expect(page.locator("#result, #measured")).to_be_visible(timeout=60_000)
    return page.locator("#verdict-words, h1").last.inner_text()


def test_a_badge_is_enrolled_by_a_live_check(page: Page, studio: Studio, pictures: Path) -> None:
    """Catches: a camera page that sends nothing, or too little; prompts that are not shown; left taken for right; a
    live enrolment that ends in a verdict alone; figures that are kept unseen, or as those of a film."""
    moves = ["left", "face", "right"]
    # A slow machine plays the film slower, so that it moves when it is no longer asked.
    words = settled(lambda: challenged(page, studio, moves, pictures), MISSED)
    assert words == "The badge of Ada Lovelace, as built", page.locator("#reasons").inner_text()
    look(page, pictures, "enrolled")
    page.get_by_role("button", name="Keep these figures").click()
    expect(page.get_by_role("status")).to_contain_text("Kept")
    expect(page.locator("main")).to_contain_text("followed prompts")
