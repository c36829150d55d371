"""A studio for a browser, and a look at its pages."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import uvicorn
from axe_playwright_python.sync_playwright import Axe
from fastapi import FastAPI
from playwright.sync_api import Page

from moireid.badge import Badge
from moireid.registry import open_registry
from moireid_studio.app import create_app
from moireid_studio.settings import Limits, Settings

SIZES = {"phone": (375, 740), "desk": (1280, 800)}


@contextmanager
def served(folder: Path, *badges: Badge, limits: Limits | None = None) -> Iterator[tuple[str, FastAPI]]:
    """The address of a studio with these badges, and its application."""
    url = f"sqlite:///{folder / 'people.sqlite3'}"
    with pytest.MonkeyPatch.context() as keys:
        keys.setenv("MOIREID_KEYS", str(folder / "keys"))
        with open_registry(url, create=True) as registry:
            for badge in badges:
                registry.enroll(badge)
        app = create_app(Settings(url, folder / "data", auth=False, limits=limits or Limits()))
        server = uvicorn.Server(uvicorn.Config(app, port=0, log_level="warning", timeout_graceful_shutdown=2))
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.02)
        yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}", app
        server.should_exit = True
        thread.join(10)


def look(page: Page, pictures: Path, name: str, *, shapes: Collection[str] = tuple(SIZES)) -> None:
    """Take pictures of a page at some widths, and let axe look at it; nothing may stick out to the side.

    Without shapes it keeps the size that it has, as a page does next to a tab that is shared.
    """
    before = page.viewport_size
    if not shapes:
        page.screenshot(path=pictures / f"{name}.png", full_page=True)
    for shape in shapes:
        width, height = SIZES[shape]
        page.set_viewport_size({"width": width, "height": height})
        page.screenshot(path=pictures / f"{name}-{shape}.png", full_page=True)
        assert page.evaluate("document.documentElement.scrollWidth") <= width, (name, shape)
    found = Axe().run(page).response["violations"]
    grave = [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in ("serious", "critical")]
    assert grave == [], name
    if before is not None:
        page.set_viewport_size(before)


def settled(verdict: Callable[[], str], *unlucky: str) -> str:
    """The words of the first verdict that is not left open, nor one of `unlucky`, or of the eighth.

    These films run in real time.  On a machine that others use too, pictures come too late to be judged; being slow
    settles nothing, so then the film is shown again.
    """
    for _ in range(8):
        words = verdict()
        if not words.startswith(("? ", *unlucky)):
            break
    return words
