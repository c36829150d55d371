"""A first badge in a real browser, from the empty form to the capture record, with pictures as a builder takes them.

Pictures of every page go to the folder that MOIREID_SCREENSHOTS names, or to the test's own.
Next to each test: the wrong implementation it catches.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import cv2
import pytest
from playwright.sync_api import Page, expect, sync_playwright

from kit.browsing import look, served
from kit.programs import needs
from moireid.badge import load_badge
from moireid.profiles import load_lens_profile
from moireid.simulate import Build, Scene, film, motion_named
from moireid_lab.bench.fabricate.calibration import STILL, PhotoCase
from moireid_lab.bench.fabricate.strip_photographs import photographed_chart

#: The sheet is finer than its label, with air under it on the badge; the printer widens lines.
LENS_SCALE, AIR_MM, GROWTH_UM = 0.9981, 0.08, 45.0
READ_MS = 240_000


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    """A page at a studio's address; a script that fails, or a style that the policy refuses, fails the test."""
    with served(tmp_path) as (site, _), sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=needs("chromium"), args=["--no-sandbox"])
        page = browser.new_context(base_url=site, viewport={"width": 1280, "height": 900}).new_page()
        said: list[str] = []
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("console", lambda message: said.append(message.text) if "Policy" in message.text else None)
        yield page
        browser.close()
        assert said == []


def send(page: Page, label: str, file: Path) -> None:
    """Choose a file, and send it."""
    form = page.locator("form.send").filter(has=page.get_by_label(label))
    form.locator("input").set_input_files(file)
    form.locator("button").click()


def download(page: Page, name: str, folder: Path) -> Path:
    """A file of the build, by the list of its files."""
    with page.expect_download() as begun:
        page.locator("dl").get_by_role("link", name=name, exact=True).click()
    begun.value.save_as(folder / name)
    return folder / name


def headed(page: Page, words: str) -> None:
    """Wait until the page says so."""
    expect(page.locator("h2").first).to_contain_text(words, timeout=READ_MS)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_builder_is_led_from_the_form_to_the_record(page: Page, tmp_path: Path) -> None:
    """Catches: a page that does not follow its round; files that cannot be had; a badge printed for the label in place
    of the sheet; films that cannot be judged where they are sealed; a record with a name; a page that a phone cannot
    show."""
    pictures = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
    pictures.mkdir(parents=True, exist_ok=True)
    page.goto("/")
    page.locator("main").get_by_role("link", name="First badge").click()
    look(page, pictures, "first-1-begin")
    page.get_by_label("Who will wear it").fill("Ada Lovelace")
    page.get_by_label("Lens sheet, as it is sold").select_option("50lpi")
    page.get_by_role("button", name="Begin").click()
    headed(page, "Next: photograph the pitch test")
    look(page, pictures, "first-2-sheet")
    page.get_by_text("Files", exact=True).wait_for()

    download(page, "pitch-test.pdf", tmp_path)
    media = next((tmp_path / "data" / "builds").glob("*/work/first-badge"))
    chart = load_badge(media / "pitch-test.json")
    bad, photo = tmp_path / "bad.jpg", tmp_path / "IMG_0001.jpeg"
    luma = photographed_chart(chart, PhotoCase("50lpi", LENS_SCALE, 0.4, 1.0, 4.0), GROWTH_UM)
    cv2.imwrite(str(photo), luma, [cv2.IMWRITE_JPEG_QUALITY, 92])
    cv2.imwrite(str(bad), luma[: luma.shape[0] // 3])
    send(page, "The photo of the pitch test", bad)
    expect(page.get_by_role("alert")).to_contain_text("could not be used", timeout=READ_MS)
    look(page, pictures, "first-3-refused")
    page.get_by_label("Focal length of the photo, px").fill(str(STILL.focal_px))
    page.get_by_label("Sheet's thickness by a calliper, mm").fill("1,0")
    page.get_by_role("button", name="Keep these figures").click()
    headed(page, "Next: photograph")
    send(page, "The photo of the pitch test", photo)
    headed(page, "Next: film the badge twice")
    look(page, pictures, "first-4-films")

    badge = load_badge(download(page, "badge.json", tmp_path))
    sheet = load_lens_profile(download(page, "sheet.json", tmp_path))
    assert badge.name == "Ada Lovelace" and badge.lens == sheet.lens
    assert badge.lens.pitch_mm == pytest.approx(0.508 * LENS_SCALE, rel=2e-4)
    scene = Scene(badge, Build(lens_scale=0.508 * LENS_SCALE / badge.lens.pitch_mm, air_gap_mm=AIR_MM))
    for number, label in ((1, "The first film of the badge"), (2, "The second film of the badge")):
        made = tmp_path / f"{number}.mp4"
        motion = motion_named("handheld", distance_mm=1000.0, seed=number)
        film(scene, motion, made, frames=180, fps=30.0, seed=number)
        send(page, label, made)
        if number == 1:
            headed(page, "Reading what you sent")
            look(page, pictures, "first-5-reading", shapes=())
            headed(page, "Next: film the badge twice")
            expect(page.locator("form.send").filter(has_text="✓ sent")).not_to_have_count(0)
    headed(page, "The first badge is built and measured")
    look(page, pictures, "first-6-done")
    row = page.get_by_role("row").filter(has_text="Air under the sheet")
    expect(row).to_contain_text("±")

    with page.context.expect_page() as opened:
        page.get_by_role("link", name="See the report").click()
    report = opened.value
    expect(report.locator("h1")).to_contain_text("is built and measured")
    assert report.locator("img").count() >= 4 and report.locator(".figures tr").count() > 8
    # Nothing runs in it, so axe does not either.
    report.screenshot(path=pictures / "first-7-report.png", full_page=True)
    report.close()

    page.get_by_text("Share the films as figures").click()
    page.get_by_label("Your words").fill("a simulated sheet")
    page.get_by_role("button", name="Make the record").click()
    page.locator("dl").get_by_role("link", name="record.json").wait_for(timeout=READ_MS)
    text = download(page, "record.json", tmp_path).read_text()
    assert json.loads(text)["kind"] == "moireid-capture-record" and len(json.loads(text)["films"]) == 2
    assert "a simulated sheet" in text and "Lovelace" not in text and str(tmp_path) not in text

    page.get_by_text("Delete this build").first.click()
    page.get_by_label("I am sure").check()
    page.get_by_role("button", name="Delete this build").click()
    expect(page.get_by_role("heading", name="Begin a build")).to_be_visible()
    assert not media.exists()
