"""A mount in 3D on the page of an issued badge.  Each test says what it catches."""

from __future__ import annotations

import io
import json
import os
import re
import zipfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
import trimesh
from fastapi import FastAPI
from PIL import Image
from playwright.sync_api import Browser, Page, expect, sync_playwright

from kit.browsing import look, served
from kit.programs import needs
from moireid.badge import Badge

pytestmark = pytest.mark.slow

STATIC = Path(__file__).parents[2] / "src" / "moireid_studio" / "static"
PARTS = Path(__file__).parents[2] / "moireid-studio.cdx.json"
WIDE = {"width": 1280, "height": 900}
#: Drawn by the processor, as there is no graphics card.
DRAWN = ("--enable-unsafe-swiftshader", "--use-angle=swiftshader")
#: Parts of the test's mount: name, size and middle in m, colour.
BODIES = [
    ("mount-tray", (0.09, 0.06, 0.004), (0.0, 0.0, 0.0), (0.1, 0.4, 0.8)),
    ("page", (0.085, 0.054, 0.0005), (0.0, 0.0, 0.003), (0.9, 0.9, 0.9)),
    ("mount-frame", (0.09, 0.06, 0.003), (0.0, 0.0, 0.006), (0.8, 0.2, 0.1)),
]


def glb(*, picture: bool = False) -> bytes:
    """A small mount as binary glTF, in metres, its bodies named and coloured; picture: one has a texture too."""
    scene = trimesh.Scene()
    for name, size, place, colour in BODIES:
        body = trimesh.creation.box(size, trimesh.transformations.translation_matrix(place))
        material = trimesh.visual.material.PBRMaterial(baseColorFactor=[*colour, 1.0], metallicFactor=0.0)
        if picture and name == "page":
            material.baseColorTexture = Image.new("RGB", (8, 8), (0, 160, 0))
        uv = np.zeros((len(body.vertices), 2)) if picture and name == "page" else None
        body.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
        scene.add_geometry(body, geom_name=name, node_name=name)
    return bytes(scene.export(file_type="glb"))


def issued(app: FastAPI, badge: Badge, **files: bytes) -> str:
    """The path of a page of a badge that was issued, with these files in its package."""
    jobs = app.state.studio.jobs
    names = [name.replace("_", ".") for name in files]
    with jobs.receiving("badge", "loopback", "admin") as job:
        job.result = {"kind": "badge", "id": badge.id, "name": badge.name, "files": names, "already_issued": False}
        job.result |= {"left_out": {}, "mount_mass_g": 12.0}
        jobs.finish(job)
    job.folder.mkdir(exist_ok=True)
    with zipfile.ZipFile(job.folder / "package.zip", "w") as packed:
        for name, content in zip(names, files.values(), strict=True):
            packed.writestr(f"badge-{badge.id}/{name}", content)
    return f"/issue/jobs/{job.id}"


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory, ada: Badge) -> Iterator[tuple[str, FastAPI]]:
    with served(tmp_path_factory.mktemp("mounts"), ada) as opened:
        yield opened


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = needs("chromium")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *DRAWN])
        yield made
        made.close()


@pytest.fixture
def page(browser: Browser, studio: tuple[str, FastAPI]) -> Iterator[Page]:
    """A page at the studio's address; what its console says of faults fails the test."""
    context = browser.new_context(base_url=studio[0], viewport=WIDE, reduced_motion="reduce")
    page, faults = context.new_page(), list[str]()
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if "Content Security" in said.text else None)
    yield page
    context.close()
    assert faults == []


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    folder = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def seen(page: Page) -> np.ndarray:
    """What the canvas shows, (height, width, 3)."""
    page.wait_for_timeout(300)
    return np.asarray(Image.open(io.BytesIO(page.locator("canvas").screenshot())).convert("RGB")).astype(int)


def share(picture: np.ndarray, colour: str) -> float:
    """Share of the pixels in which one colour is by far the strongest."""
    channel = "rgb".index(colour)
    others = np.delete(picture, channel, axis=2).max(axis=2)
    return float((picture[:, :, channel] > others + 40).mean())


def test_the_parts_are_shown_in_their_colours_and_turned_by_keys(
    page: Page, studio: tuple[str, FastAPI], ada: Badge, pictures: Path
) -> None:
    """Catches: an empty canvas; parts without name or colour; a view that a mouse alone turns; one that turns by
    itself; a script or a wasm from elsewhere.
    """
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(issued(studio[1], ada, mount_glb=glb(), assembly_pdf=b"%PDF-"))
    expect(page.locator("[data-status]")).to_have_text("3 parts are shown.", timeout=60_000)
    assert [one.strip() for one in page.locator(".parts li").all_inner_texts()] == ["mount tray", "page", "mount frame"]
    first = seen(page)
    assert share(first, "r") > 0.05 and np.array_equal(first, seen(page))
    look(page, pictures, "mount")
    page.set_viewport_size(WIDE)
    first = seen(page)
    canvas = page.locator("canvas")
    canvas.focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        before = seen(page)
        page.keyboard.press(key)
        assert np.abs(seen(page) - before).mean() > 0.5, key
    page.keyboard.press("Home")
    assert np.abs(seen(page) - first).mean() < 0.1
    # The tray is behind the frame, until the parts are pulled apart.
    blue = share(first, "b")
    page.get_by_label("Pull the parts apart").fill("1")
    assert share(seen(page), "b") > blue + 0.02
    look(page, pictures, "mount-apart")
    for name in ("Nearer", "Farther", "Turn left", "Turn right"):
        before = seen(page)
        page.get_by_role("button", name=name).click()
        assert np.abs(seen(page) - before).mean() > 0.5, name
    assert {url.split("/")[2] for url in asked if not url.startswith("blob:")} == {studio[0].split("/")[2]}
    with page.expect_download() as coming:
        page.get_by_role("link", name="assembly.pdf").click()
    assert Path(coming.value.path()).read_bytes() == b"%PDF-"


def test_only_the_one_who_issued_gets_the_model(page: Page, studio: tuple[str, FastAPI], ada: Badge) -> None:
    """Catches: files of another's job; a name that leads out of the package."""
    path = issued(studio[1], ada, mount_glb=glb())
    job = path.rpartition("/")[2]
    answer = page.request.get(f"/api/badges/jobs/{job}/mount.glb")
    assert answer.status == 200 and answer.headers["content-type"] == "model/gltf-binary"
    for name, status in (("stack.glb", 422), ("badge.json", 422), ("..%2Fbadge.json", 404), ("assembly.pdf", 404)):
        assert page.request.get(f"/api/badges/jobs/{job}/{name}").status == status, name
    assert page.request.get(f"/api/badges/jobs/{'0' * 32}/mount.glb").status == 404


def test_the_library_is_as_the_list_of_parts_states() -> None:
    """Catches: a library that was changed by hand, or renewed without its entry; one too large for a phone; one
    without its licence; one that names a server.
    """
    library = (STATIC / "three.js").read_bytes()
    (part,) = json.loads(PARTS.read_text())["metadata"]["component"]["components"]
    assert part["purl"] == f"pkg:npm/three@{part['version']}" and part["licenses"][0]["license"]["id"] == "MIT"
    assert part["hashes"] == [{"alg": "SHA-256", "content": sha256(library).hexdigest()}]
    assert re.findall(rb'revision:"(\d+)"', library) == [part["version"].split(".")[1].encode()]
    assert len(library) < 700_000 and b"SPDX-License-Identifier: MIT" in library
    assert "The MIT License" in (STATIC / "three.LICENSE").read_text()
    assert set(re.findall(rb"https?://[\w./-]+", library)) == {b"http://www.w3.org/1999/xhtml"}
