"""Lists of people in the studio, with pictures next to them.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import html
import io
import re
import time
import zipfile
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from kit.webbing import OpenStudio, Visit, film_form
from moireid.badge import badge_from_json
from moireid_studio.jobs.lists import FOR_ALL

COLOURS = {"red.png": (220, 0, 0), "green.png": (0, 160, 0), "blue.png": (0, 0, 220)}
WISH = {"format": "a7", "template": "newsroom"}


def picture(colour: tuple[int, int, int]) -> bytes:
    made = io.BytesIO()
    Image.new("RGB", (80, 100), colour).save(made, "PNG")
    return made.getvalue()


PICTURES = [("pictures", (name, picture(colour))) for name, colour in COLOURS.items()]


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio()


def sent(visit: Visit, people: str, files: list[tuple[str, tuple[str, bytes]]], **fields: str) -> httpx.Response:
    data = {"people": people, "do": "check"} | WISH | fields
    return visit.ask("POST", "/issue/event", "issuer", data=data, files=[*files, ("people_file", ("", b""))])


@pytest.mark.slow
def test_rows_wear_their_own_pictures_and_namesakes_are_distinguished(visit: Visit) -> None:
    """Catches: pictures that go to the wrong rows, are lost on the way to the print or must be chosen twice; lines of
    one namesake on the other's badge, a claim of one that means the other."""
    people = (
        "name,line1,line2,portrait,logo,colour\n"
        "Ana Silva,Reporter,Daily News,red.png,,\n"
        "Ana Silva,Editor,,faces/Green.PNG,blue.png,teal\n"
        "Bob,,,,,\n"
    )
    page = sent(visit, people, PICTURES)
    assert page.status_code == 200, page.text
    assert "3 badges can be issued" in page.text and "with its own logo and portrait" in page.text
    kept = re.findall(r'name="kept" value="(\w+)"', page.text)[0]
    moved = sent(visit, people, [], kept=kept, lines="Guest", do="issue")
    assert moved.status_code == 303, moved.text
    job = moved.headers["location"].rsplit("/", 1)[1]
    begun = time.monotonic()
    while (issued := visit.ask("GET", f"/api/badges/jobs/{job}", "issuer").json())["state"] not in ("done", "failed"):
        assert time.monotonic() - begun < 200
        time.sleep(0.1)
    assert issued["state"] == "done", issued
    assert [one["line"] for one in issued["result"]["people"]] == ["Reporter", "Editor", "Guest"]
    package = visit.ask("GET", f"/api/badges/jobs/{job}/package.zip", "issuer").content
    shown = []
    with zipfile.ZipFile(io.BytesIO(package)) as archive:
        for folder in ("001-ana-silva", "002-ana-silva", "003-bob"):
            badge = badge_from_json(archive.read(f"event/{folder}/badge.json").decode())
            pixels = np.asarray(Image.open(io.BytesIO(archive.read(f"event/{folder}/preview.png"))).convert("RGB"), int)
            worn = {name for name, colour in COLOURS.items() if (np.abs(pixels - colour).max(-1) < 30).mean() > 0.002}
            shown.append(((badge.print or {}).get("lines"), worn))
        names = archive.namelist()
    assert shown == [
        (["Reporter", "Daily News"], {"red.png"}),
        (["Editor"], {"green.png", "blue.png"}),
        (["Guest"], set()),
    ]
    assert not [name for name in names if name.endswith(tuple(COLOURS))]
    # Each namesake is claimed by the id, here as by the command, and no one by the name.
    ids = [one["id"] for one in issued["result"]["people"]]
    film = film_form(b"\0\0\0\x18ftypmp42" + b"\0" * 600)
    for badge_id in ids[:2]:
        claim = visit.ask("POST", "/api/jobs", "verifier", files=film["files"], data={"claim": badge_id})
        assert claim.status_code == 202, claim.text
        assert visit.job(claim.json()["id"]).claimed_id == badge_id
    both = visit.ask("POST", "/api/jobs", "verifier", files=film["files"], data={"claim": "Ana Silva"})
    assert both.status_code == 409 and ids[0] not in both.json()["text"]
    again = html.unescape(sent(visit, "name,line1\nAna Silva,Editor\nAna Silva,Guest\nBob,\n", []).text)
    assert again.count(" has the name too, so claims") == 3
    record = visit.ask("POST", "/issue", "issuer", data={"name": "Ana Silva", "lines": "Guest", "do": "check"}).text
    assert "which badge is meant by its id" in record and "(<bdi>Editor</bdi>)" in record


def test_a_row_that_names_no_chosen_picture_is_refused_with_its_row(visit: Visit, tmp_path: Path) -> None:
    """Catches: a path in a list that reads a file of the server; a picture that is left out without a word."""
    secret = tmp_path / "secret.png"
    secret.write_bytes(picture((1, 2, 3)))
    count = visit.studio.registry.count()
    for cell in (
        str(secret),
        "../" * 12 + str(secret)[1:],
        "secret.png",
        "pictures/0.png",
        "0.png",
        FOR_ALL,
        "red .png",
    ):
        page = sent(visit, f"name,portrait\nGood,red.png\nBad,{cell}\n", PICTURES, do="issue")
        words = html.unescape(page.text)
        assert page.status_code == 422 and "1 of 2 rows cannot be used" in words, cell
        assert (
            f"row 3 of the list ('Bad'): the portrait '{cell[:80]}' is not among the pictures that were chosen" in words
        )
        assert "choose that file too, or leave the cell empty" in words and "(--" not in words
        assert re.findall(r'name="kept" value="(\w+)"', page.text)
    assert visit.studio.registry.count() == count
    # A part of a path finds the file of that name among those that were chosen, as no other folder is known.
    assert sent(visit, f"name,portrait\nGood,{tmp_path}/red.png\n", PICTURES).status_code == 200
