"""Badges to wear, from the form and the API.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import base64
import html
import io
import json
import re
import time
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pypdfium2 as pdfium
import pytest
from click.testing import CliRunner
from PIL import Image

from kit.webbing import OpenStudio, Visit
from moireid.badge import badge_from_json
from moireid.cli.main import moireid
from moireid.designer.formats import FORMATS

MAGENTA, GREEN = (255, 0, 255), (0, 160, 0)
LOGO = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 60 20"><path d="M0 0h60v20H0z" fill="#ff00ff"/></svg>'
WISH = {"format": "a7", "mount": "none", "template": "newsroom"}


def portrait(colour: tuple[int, int, int] = GREEN) -> bytes:
    made = io.BytesIO()
    Image.new("RGB", (80, 100), colour).save(made, "PNG")
    return made.getvalue()


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio()


def fields_of(page: str) -> dict[str, str]:
    """What a page's form would send again: hidden and typed fields, chosen radios and options; no box is ticked."""
    typed = re.sub(r"<input[^>]*(radio|checkbox)[^>]*>", "", page)
    found = dict(re.findall(r'<input[^>]*? name="(\w+)"[^>]*? value="([^"]*)"', typed))
    found |= dict(re.findall(r'<input type="radio" name="(\w+)" value="([^"]*)" checked', page))
    for name, options in re.findall(r'<select id="\w+" name="(\w+)">(.*?)</select>', page, re.S):
        found[name] = re.findall(r'value="([^"]*)" selected', options)[0]
    for name, text in re.findall(r'<textarea[^>]*? name="(\w+)"[^>]*>(.*?)</textarea>', page, re.S):
        found[name] = text.removeprefix("\n")
    return {name: html.unescape(value) for name, value in found.items()}


def made(visit: Visit, job: str) -> tuple[dict[str, Any], dict[str, bytes]]:
    """The result of a job of issuing, and the files of its package by name."""
    begun = time.monotonic()
    while (result := visit.ask("GET", f"/api/badges/jobs/{job}", "issuer").json())["state"] not in ("done", "failed"):
        assert time.monotonic() - begun < 200
        time.sleep(0.1)
    assert result["state"] == "done", result
    package = visit.ask("GET", f"/api/badges/jobs/{job}/package.zip", "issuer")
    with zipfile.ZipFile(io.BytesIO(package.content)) as archive:
        return result["result"], {name: archive.read(name) for name in archive.namelist()}


def share(picture: Image.Image, colour: tuple[int, int, int]) -> float:
    """How much of a picture has about that colour."""
    pixels = np.asarray(picture.convert("RGB"), dtype=int)
    return float((np.abs(pixels - colour).max(axis=-1) < 40).mean())


@pytest.mark.slow
def test_pictures_lines_and_colour_reach_the_print_from_the_form(visit: Visit) -> None:
    """Catches: a logo or portrait that is lost between check and issue or on the way to the printing process, lines
    that are not in the record, a size that is not the format's, a preview of another badge."""
    typed = WISH | {"name": "Nellie Bly", "lines": "Reporter\n\n  Example News ", "colour": "#0000ff", "do": "check"}
    files = {"logo": ("logo.svg", LOGO), "portrait": ("face.png", portrait())}
    checked = visit.ask("POST", "/issue", "issuer", data=typed, files=files)
    assert checked.status_code == 200 and "What would be made" in checked.text, checked.text[:3000]
    assert "logo.svg" in checked.text and "face.png" in checked.text
    seen = re.search(r'<img src="data:image/webp;base64,([^"]*)"', checked.text)
    assert seen is not None
    with Image.open(io.BytesIO(base64.b64decode(html.unescape(seen.group(1))))) as picture:
        assert min(share(picture, MAGENTA), share(picture, GREEN)) > 0.003
    # No file is sent again.
    again = fields_of(checked.text) | {"do": "issue"}
    assert {name: again[name] for name in WISH} == WISH and again["lines"] == typed["lines"]
    moved = visit.ask("POST", "/issue", "issuer", data=again)
    assert moved.status_code == 303, moved.text
    job = moved.headers["location"].rsplit("/", 1)[1]
    result, found = made(visit, job)
    top = f"badge-{result['id']}/"
    badge = badge_from_json(found[top + "badge.json"].decode())
    assert badge.print is not None and badge.print["lines"] == ["Reporter", "Example News"]
    x0, y0, x1, y1 = badge.outline_mm
    assert (x1 - x0, y1 - y0) == pytest.approx(FORMATS["a7"].size_mm)
    record = visit.studio.registry.by_id(result["id"])
    assert record is not None and record.badge == badge and record.line == "Reporter"
    with pdfium.PdfDocument(found[top + "badge.pdf"]) as document:
        page = document[0].render(scale=2).to_pil()
        assert "Example News" in document[0].get_textpage().get_text_bounded()
    preview = Image.open(io.BytesIO(found[top + "preview.png"]))
    for shown in (page, preview):
        assert min(share(shown, MAGENTA), share(shown, GREEN)) > 0.003
    # The moving preview is shown on the page, from the package, as a picture and nothing else.
    shown_page = visit.ask("GET", f"/issue/jobs/{job}", "issuer")
    address = re.search(r'<img class="made" src="([^"]*)"', shown_page.text)
    assert address is not None
    for path in (address.group(1), f"/api/badges/jobs/{job}/preview.webp"):
        moving = visit.ask("GET", path, "issuer")
        assert moving.headers["content-type"] == "image/webp" and moving.headers["x-content-type-options"] == "nosniff"
        assert moving.content == found[top + "preview.webp"] and Image.open(io.BytesIO(moving.content)).is_animated
        assert visit.ask("GET", path, "admin").status_code == 404 and visit.ask("GET", path, None).status_code == 401


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fields", "arguments"),
    [
        (
            {"format": "a6", "orientation": "portrait", "markers": "frame"},
            ["--format", "a6", "--orientation", "portrait", "--markers", "frame"],
        ),
        (
            {"format": "webcam", "colour": "teal", "lines": "Guest"},
            ["--format", "webcam", "--colour", "teal", "--line", "Guest"],
        ),
        ({"axes": "hex"}, ["--axes", "hex"]),
        (
            {"format": "a5", "template": "court", "far_m": "1.5"},
            ["--format", "a5", "--template", "court", "--range", "0.6-1.5"],
        ),
    ],
)
def test_a_wish_gives_the_command_s_own_badge(
    visit: Visit, fields: dict[str, str], arguments: list[str], tmp_path: Path
) -> None:
    """Catches: a choice that does nothing, a sheet or a range that is not the command's, a frame without its room."""
    wish = {"name": "Ada", "payload": "7097c67b0fafc59b", "mount": "none"}
    body: dict[str, Any] = wish | fields
    body |= {"lines": fields["lines"].splitlines()} if "lines" in fields else {}
    body |= {"range_m": [0.6, float(body.pop("far_m"))]} if "far_m" in fields else {}
    answer = visit.ask("POST", "/api/badges/check", "issuer", json=body)
    out = tmp_path / "out"
    result = CliRunner().invoke(
        moireid, ["print", "Ada", "--payload", wish["payload"], "--out", str(out), "--mount", "none", *arguments]
    )
    assert result.exit_code == 0, result.stderr
    by_command = badge_from_json((out / "badge.json").read_text())
    assert answer.status_code == 200, answer.text
    assert badge_from_json(json.dumps(answer.json()["badge"])) == by_command
