"""*Check a call* in a real browser: a page with a call's layout plays films of a badge, and its tab is shared.

Each test names what it would catch.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import av
import cv2
import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from kit.browsing import look, served, settled
from kit.programs import needs
from moireid.badge import Badge
from moireid_lab.bench.live import FACE_MM, answer, frames, portrait
from moireid_studio.challenge.challenge import FACE, Prompt

#: A session lasts as long as its film, and browser, studio and judge keep both processors of a small machine busy.
pytestmark = [pytest.mark.slow, pytest.mark.alone]

FPS, SIZE = 24.0, (736, 414)
#: What the film's person does, and when; between two moves the film is stopped until it goes on.
MOVES = ("left", "right", "right", FACE, "left")
MOVES_S = (3.0, 5.0, 7.0, 9.0, 12.0)
STOPS_S = (2.8, 4.8, 6.8, 8.8, 11.8, 14.0)
CALL = """<!doctype html><title>The call</title><style>
body { margin: 0; background: #202124; font: 16px sans-serif; color: #fff; }
div { position: absolute; overflow: hidden; border-radius: 12px; background: #3c4043; }
video, img { width: 100%; height: 100%; object-fit: cover; display: block; }
p { position: absolute; left: 12px; bottom: 4px; margin: 0; }
</style>
<div id="them" style="left: 20px; top: 60px; width: 736px; height: 414px"><video muted></video><p>Ada</p></div>
<div style="left: 776px; top: 60px; width: 192px; height: 108px"><img src="me.jpg"><p>You</p></div>
<script>
const stops = STOPS, video = document.querySelector("video");
let at = 0;
const play = async (film) => {
  video.src = URL.createObjectURL(await (await fetch(film)).blob());
  at = 0;
  await video.play();
};
const goOn = () => { at += 1; video.play(); };
setInterval(() => { if (video.currentTime >= stops[at]) video.pause(); }, 10);
</script>"""


@dataclass
class Call:
    """The page of the call, the asker's page, the studio's address, and the moves that it will ask for."""

    page: Page
    asker: Page
    url: str
    moves: list[str] = field(default_factory=list)

    def share(self, film: str, width: int = 736) -> None:
        """Play a film in a tile of this width, and share the call; ends where a tile is to be chosen."""
        height = width * 9 // 16
        self.page.evaluate(f"Object.assign(them.style, {{ width: '{width}px', height: '{height}px' }})")
        self.page.evaluate(f"play('{film}')")
        self.asker.goto(f"{self.url}/call")
        self.asker.get_by_label("Whose badge").fill("Ada Lovelace")
        self.asker.get_by_role("button", name="Share the call's window").click()
        expect(self.asker.locator("#choose")).to_be_visible(timeout=20_000)

    def challenge(self) -> str:
        """Choose the larger tile, and let the film answer each sentence; the verdict's words."""
        self.asker.get_by_role("button", name="Tile of").first.click()
        start = self.asker.get_by_role("button", name="Start the sentences")
        expect(start).to_be_enabled(timeout=60_000)
        start.click()
        output = 0
        while not self.asker.locator("#result").is_visible():
            if (self.asker.locator("#count").text_content() or "").startswith(f"{output + 1} of"):
                output += 1
                time.sleep(0.3)
                self.page.evaluate("goOn()")
            assert not self.asker.locator("#problem").is_visible(), self.asker.locator("#problem").text_content()
            time.sleep(0.05)
        return self.asker.locator("#verdict-words").inner_text()

    def settled(self, film: str) -> str:
        """The verdict's words on a film, `settled`."""

        def once() -> str:
            self.share(film)
            return self.challenge()

        return settled(once)

    def reasons(self) -> str:
        return self.asker.locator("#reasons").inner_text()


def filmed(badge: Badge, path: Path, *, moves: tuple[str, ...] = MOVES, frozen: bool = False) -> None:
    """A person who moves a badge as `moves` say, at `MOVES_S`; frozen: with fringes that do not move."""
    course = answer([Prompt(*one) for one in zip(moves, MOVES_S, strict=True)], FACE_MM, reaction_s=0.0)
    with av.open(str(path), "w") as made:
        stream = made.add_stream(
            "libx264", rate=round(FPS), options={"crf": "18", "preset": "veryfast", "threads": "2"}
        )
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        shot = frames(badge, portrait(), course, length_s=STOPS_S[-1] + 1, fps=FPS, frozen=frozen)
        for number, picture in enumerate(shot):
            small = cv2.resize(picture, SIZE, interpolation=cv2.INTER_AREA)
            frame = av.VideoFrame.from_ndarray(small, format="gray")
            frame.pts, frame.time_base = number, Fraction(1, round(FPS))
            made.mux(stream.encode(frame))
        made.mux(stream.encode())


@pytest.fixture(scope="module")
def films_at(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Iterator[str]:
    """The address of another site, with the call's page and its films."""
    folder = tmp_path_factory.mktemp("call")
    filmed(ada, folder / "true.mp4")
    filmed(ada, folder / "forged.mp4", frozen=True)
    cv2.imwrite(str(folder / "me.jpg"), portrait()[::5, ::5])
    (folder / "call.html").write_text(CALL.replace("STOPS", str(list(STOPS_S))))
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/call.html"
    server.shutdown()


class Quiet(SimpleHTTPRequestHandler):
    """Serves files without a log."""

    def log_message(self, *_: object) -> None:
        return


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = needs("chromium")
    with sync_playwright() as playwright:
        # The tab of that title is shared without a question.
        shares = "--auto-select-tab-capture-source-by-title=The call"
        made = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", shares])
        yield made
        made.close()


@pytest.fixture
def call(browser: Browser, films_at: str, tmp_path: Path, ada: Badge) -> Iterator[Call]:
    with served(tmp_path, ada) as (url, app):
        context = browser.new_context(viewport={"width": 1000, "height": 560})
        page = context.new_page()
        page.goto(films_at)
        made = Call(page, context.new_page(), url, list(MOVES))
        app.state.live_prompts = lambda start_s: [Prompt(move, start_s + 1.7 * k) for k, move in enumerate(made.moves)]
        yield made
        context.close()


def test_a_call_is_accepted_when_its_sentences_are_answered(call: Call, pictures: Path) -> None:
    """Catches: a shared window of which nothing or the wrong part is sent; sentences that nobody is shown; a delay that
    is taken for disobedience."""
    call.asker.goto(f"{call.url}/call")
    look(call.asker, pictures, "call-form")
    call.share("true.mp4")
    expect(call.asker.get_by_role("button", name="Tile of")).to_have_count(2)
    look(call.asker, pictures, "call-tiles", shapes=())
    assert call.settled("true.mp4") == "✓ Genuine, live, and Ada Lovelace's", call.reasons()
    look(call.asker, pictures, "call-accepted")
