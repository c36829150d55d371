"""The kernel in a real browser, and the film that the page *Verify* reads there before it is sent.

Next to each test: the wrong implementation it catches.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, Route, sync_playwright

import moireid_studio
from kit.browsing import look, served
from kit.drawn_pages import apart_px, nudged
from kit.programs import needs
from moireid.badge import load_badge
from moireid.verifier.kernel.page import PageRows, Points
from moireid.verifier.tracking.registration import PageRegistrar, scale_px_per_mm
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.tracking.track import board_px
from moireid.verifier.video import Film
from moireid_studio.pages.film_view import print_bytes, view_geometry

STUDIO = Path(moireid_studio.__file__).parent
SAMPLES = STUDIO / "samples"
#: A film of 4 s is played in real time, and a busy machine takes many times that.
PATIENCE_MS = 60_000


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    program = needs("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page()
        page.set_default_timeout(PATIENCE_MS)
        yield page
        browser.close()


def serve(route: Route) -> None:
    """The scripts and the kernel by name, and an empty page for anything else."""
    name = route.request.url.rsplit("/", 1)[-1]
    if name.endswith(".js"):
        route.fulfill(body=(STUDIO / "static" / name).read_text(encoding="utf-8"), content_type="text/javascript")
    elif name == "kernel.wasm":
        kernel = resources.files("moireid.verifier.kernel").joinpath(name).read_bytes()
        route.fulfill(body=kernel, content_type="application/wasm")
    else:
        route.fulfill(body="<!doctype html>", content_type="text/html")


def row_places(geometry: dict[str, Any]) -> NDArray[np.float64]:
    """The samples of the row, page mm, (lines x samples, 2)."""
    row = geometry["row"]
    line, sample = np.divmod(np.arange(row["lines"] * row["samples"]), row["samples"])
    steps = np.outer(sample, row["along_mm"]) + np.outer(line, row["across_mm"])
    return np.array(row["begin_mm"]) + steps


def test_the_browser_s_kernel_registers_and_reads_as_the_native_one(page: Page, films: Path) -> None:
    """Catches: a struct whose fields are elsewhere in WebAssembly, a print whose arrays are exchanged, another version
    of the kernel: 1e-4 px of the page and a count of light; a search that takes squares for each other: 2 px.
    """
    badge = load_badge(films / "badge.json")
    film, scene = Film(films / "genuine_1.0m.mp4").frames(), SceneTracker(badge)
    frame = next(frame for frame in film if scene.push(frame))
    truth = scene.trackers[0].ends.first.page
    registrar, geometry = PageRegistrar(badge.markers), view_geometry(badge)
    start, scale = nudged(truth, 0.8, -0.6), scale_px_per_mm(truth, registrar.printer.middle)
    # As the browser does: by all samples from the start.
    template = registrar.printer.draw(scale)
    registrar._print_of(template).prepare(template.gradient() * np.float32(registrar.printer.extent))
    native = registrar.register(frame.picture, start, template)
    assert native is not None
    height, width = frame.picture.shape
    samples = np.frombuffer(print_bytes(badge, scale), "<f4").tolist()
    places = (row_places(geometry) - registrar.printer.middle) / registrar.printer.extent
    page.route("**/*", serve)
    page.goto("http://studio.test/")
    found = page.evaluate(
        """async ([geometry, samples, coded, width, height, start, places, scale]) => {
        const { levelsOf, loadKernel, PageKernel } = await import("/kernel.js");
        const { findPage } = await import("/squares.js");
        const kernel = new PageKernel(await loadKernel(), geometry.rules);
        const bytes = Uint8Array.from(atob(coded), (letter) => letter.charCodeAt(0));
        const picture = { width, height, stride: width, offset: 0, bytes: bytes.length };
        const room = kernel.preparePicture({ ...picture, ...levelsOf(false) });
        kernel.pictureBytes(room).set(bytes);
        const print = kernel.preparePrint(Float32Array.from(samples), 4, scale * geometry.extent_mm, geometry);
        const warp = kernel.register(print, start, 0.8);
        const row = kernel.prepareRow(...[0, 1].map((k) => places.map((place) => place[k])), geometry.row.samples);
        const box = { left: 0, top: 0, width, height };
        return [warp, [...kernel.readRow(row, warp)], findPage({ ...picture, bytes }, box, geometry)];
    }""",
        [
            geometry,
            samples,
            _base64(frame.picture.coded((0, 0, width, height))),
            width,
            height,
            (start @ registrar._to_page).ravel().tolist(),
            places.tolist(),
            scale,
        ],
    )
    warp, profile, searched = (np.array(one) for one in found)
    assert apart_px(native.homography, warp.reshape(3, 3) @ registrar._from_page) < 1e-4
    counts = np.array([geometry["row"]["lines"]], np.int32)
    light = frame.picture.in_light.struct
    places, samples = Points(row_places(geometry)), geometry["row"]["samples"]
    rows = PageRows(places, counts, samples, 0.0).read(light, native.homography)
    # A value that is half way between two counts may be rounded to either.
    assert np.abs(profile - rows[0]).max() < 1.0 and np.abs(profile - rows[0]).mean() < 0.01
    assert apart_px(native.homography, searched.reshape(3, 3) @ registrar._from_page) < 2.0


def _base64(rows: NDArray[np.uint8]) -> str:
    return base64.b64encode(np.ascontiguousarray(rows).tobytes()).decode()


@pytest.mark.slow
@pytest.mark.parametrize(("film", "agrees"), [("true", True), ("forged", False)])
def test_a_chosen_film_is_followed_before_it_is_sent(page: Page, film: str, agrees: bool, tmp_path: Path) -> None:
    """Catches: an outline elsewhere than the verifier's (2 px), a law that follows any fringes, a trace that stays
    empty, a film that is sent before the visitor asks for it, a policy under which the kernel cannot run.
    """
    badge, path = load_badge(SAMPLES / "badge.json"), SAMPLES / f"{film}.mp4"
    sent: list[tuple[str, str]] = []
    said: list[str] = []
    page.unroute_all()
    page.on("request", lambda request: sent.append((request.method, request.url)))
    page.on("console", lambda message: said.append(message.text))
    with served(tmp_path, badge) as (home, _):
        page.goto(f"{home}/verify")
        page.evaluate("view.addEventListener('badge', ({ detail }) => (globalThis.seen ??= []).push(detail))")
        page.get_by_label("Name or id").fill(badge.name)
        page.get_by_label("The film", exact=True).set_input_files(path)
        page.get_by_role("button", name="Play again").wait_for()
        frames = page.evaluate("seen")
        folder = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
        look(page, folder, f"film-view-{film}")
        page.goto("about:blank")
    assert said == [] and {method for method, _ in sent} == {"GET"}
    assert len(frames) > 10 and len({round(frame["seen"], 4) for frame in frames}) > 10
    native = outlines(path, {frame["time"] for frame in frames})
    assert len(native) > 5
    apart = [
        np.abs(np.array(frame["outline"]) - native[frame["time"]]).max() for frame in frames if frame["time"] in native
    ]
    assert np.median(apart) < 0.5 and max(apart) < 2.0
    seen, law = (np.array([frame[name] for frame in frames]) for name in ("seen", "law"))
    # Half of the frames at the end, when gain and constants have settled.
    half = len(frames) // 2
    assert bool(np.std((seen - law)[half:]) < 0.05) == agrees


def outlines(path: Path, times: set[float]) -> dict[float, NDArray[np.float64]]:
    """The badge's corners (4, 2) px by the verifier, by those times of a browser that are also its own, to 1 ms."""
    badge = load_badge(SAMPLES / "badge.json")
    scene, found = SceneTracker(badge), {}
    wanted = {round(time, 3): time for time in times}
    for frame in Film(path).frames():
        if scene.push(frame) and round(frame.time_s, 3) in wanted:
            page = scene.trackers[0].ends.last.page
            found[wanted[round(frame.time_s, 3)]] = board_px(badge, page, None)
    return found
