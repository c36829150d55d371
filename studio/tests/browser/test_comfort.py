"""The studio as tired people use it: on a phone, with a poor camera, with many films, and with every choice once.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

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


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    """Where pictures of the page go: where MOIREID_SCREENSHOTS says, or to the test's own folder."""
    folder = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.mark.parametrize("width", [390, 360])
@pytest.mark.parametrize("script", [True, False])
def test_a_phone_has_the_whole_navigation_behind_one_button(
    browser: Browser, home: str, pictures: Path, width: int, *, script: bool
) -> None:
    """Catches: entries past the edge that only a finger finds; half a screen of links above each page; a menu that
    needs a script, or that no key opens and shuts.
    """
    with browser.new_context(
        base_url=home, viewport={"width": width, "height": 740}, java_script_enabled=script
    ) as own:
        page = own.new_page()
        page.goto("/verify")
        links, menu = page.locator(".top nav a"), page.get_by_role("button", name="Menu")
        assert links.count() == 10 and not any(link.is_visible() for link in links.all())
        header = page.locator(".top").bounding_box()
        assert header is not None and header["height"] <= 70
        menu.focus()
        page.keyboard.press("Enter")
        expect(links.last).to_be_visible()
        for link in links.all():
            box = link.bounding_box()
            assert box is not None and box["x"] >= 0 and box["x"] + box["width"] <= width and box["height"] >= 44
            assert box["y"] + box["height"] <= 740
        page.screenshot(path=pictures / f"menu-{width}.png")
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.textContent") == "Issue"
        page.keyboard.press("Escape")
        expect(links.last).to_be_hidden()
        menu.click()
        links.filter(has_text="Registry").click()
        page.wait_for_url("**/registry")


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


@pytest.mark.parametrize("path", ["/registry", "/registry/audit", "/links", "/help"])
def test_other_pages_at_every_width(page: Page, pictures: Path, path: str) -> None:
    """Catches: as above."""
    test_pages_at_every_width(page, pictures, path)


def test_a_slow_camera_is_named_and_another_can_be_chosen(page: Page, pictures: Path) -> None:
    """Catches: a person who is blamed for their camera; prompts that lie over the badge in the mirror."""
    page.goto("/live")
    page.get_by_label("Whose badge").fill("Ada Lovelace")
    page.get_by_role("button", name="Start the camera").click()
    expect(page.locator("#slow")).to_contain_text("pictures a second; 24 are wanted", timeout=60_000)
    camera = page.get_by_label("Camera", exact=True)
    expect(camera.locator("option")).to_have_count(2)
    first = camera.input_value()
    camera.select_option(index=1)
    expect(page.locator("#video")).to_have_js_property("paused", False)
    assert camera.input_value() != first and not page.locator("#problem").is_visible()
    page.locator("#prompt").evaluate(
        "one => { one.hidden = false; one.children[1].textContent = 'Hold it across your face'; }"
    )
    for size in (PHONE, WIDE):
        page.set_viewport_size(size)
        prompt, picture = page.locator("#prompt").bounding_box(), page.locator("#video").bounding_box()
        assert prompt is not None and picture is not None
        assert prompt["y"] + prompt["height"] <= picture["y"] + 1
    look(page, pictures, "live-slow")
    page.get_by_role("button", name="Stop").click()
    expect(page.locator("#result")).to_be_visible()


def test_a_link_leads_a_person_through_and_the_asker_reads_it(page: Page, browser: Browser, pictures: Path) -> None:
    """Catches: a link that no one can follow; a result that does not come; a second opening that is not reported."""
    page.goto("/links")
    look(page, pictures, "links")
    page.get_by_label("Who should it be").fill("Ada Lovelace")
    page.get_by_label("Who asks").fill("Sam of the accounts department")
    page.get_by_label("Ask to keep some pictures").check()
    page.get_by_role("button", name="Make a link").click()
    address = page.get_by_label("The link").input_value()
    look(page, pictures, "link-made")
    page.get_by_role("link", name="See what becomes of it").click()
    expect(page.get_by_role("status")).to_contain_text("Not opened yet")
    with browser.new_context(viewport=WIDE) as context:
        person = context.new_page()
        person.goto(address)
        expect(person.locator("#asks")).to_have_text("Sam of the accounts department")
        expect(person.locator("#name")).to_have_text("Ada Lovelace")
        look(person, pictures, "check")
        expect(page.get_by_role("status")).to_contain_text("Opened, not begun")
        person.get_by_role("button", name="Start the camera").click()
        expect(person.locator("#stage")).to_be_visible(timeout=60_000)
        expect(page.get_by_role("status")).to_contain_text("The check runs")
        look(page, pictures, "link-running")
        person.get_by_role("button", name="Stop").click()
        expect(person.get_by_text("This verdict was sent to the one who asked")).to_be_visible(timeout=60_000)
        look(person, pictures, "check-done")
        person.reload()
        expect(person.get_by_role("alert")).to_contain_text("it works once, so ask for another")
        assert not person.locator("#who").is_visible()
        look(person, pictures, "check-again")
    expect(page.get_by_role("heading", level=1)).to_contain_text("Cannot tell", timeout=60_000)
    look(page, pictures, "link-done")
    with page.expect_download() as coming:
        page.get_by_role("link", name="Receipt").click()
    assert "Ada Lovelace" in Path(coming.value.path()).read_text()
    page.get_by_role("button", name="Remove this link").click()
    expect(page.get_by_text("You have made no link yet.")).to_be_visible()


@pytest.mark.parametrize("path", ["/issue", "/issue/event"])
def test_every_choice_of_the_forms_that_issue_is_taken(page: Page, path: str) -> None:
    """Catches: a choice that the form offers and the studio knows nothing of, or that ends in an error."""
    page.goto(path)
    choices = page.evaluate(
        "[...document.querySelectorAll('main select')].flatMap(one => [...one.options].map(o => [one.id, o.value]))"
    )
    assert len(choices) >= 20
    for name, value in choices:
        page.goto(path)
        page.locator("main details").evaluate_all("all => all.forEach(one => { one.open = true })")
        if path == "/issue":
            page.get_by_label("Name", exact=True).fill("Bea")
        else:
            page.get_by_label("or the list itself").fill("name\nBea\n")
        page.locator(f"#{name}").select_option(value)
        page.get_by_role("button", name="Check").first.click()
        page.wait_for_load_state()
        assert page.locator(f"#{name}").input_value() == value
        done, why = page.locator("#result"), page.locator("#problem")
        output = why.text_content() if why.count() else ""
        # A lens that these sizes do not allow is refused in a sentence that says what would do.
        assert done.count() == 1 or (output and output.strip().endswith(".")), (name, value, output)
        assert done.count() == 1 or name == "lens", (name, value, output)
