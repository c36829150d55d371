"""Badges for many people.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import csv
import json
from codecs import BOM_UTF8
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pypdfium2 as pdfium
import pytest
from click.testing import CliRunner, Result

from kit.drawn import geometry
from kit.payloads import payload_for_name
from moireid.badge import load_badge
from moireid.cli.main import moireid
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.event import write_sheets_pdf
from moireid.fabrication.page.sheet_layout import lay_out_sheets
from moireid.registry import open_registry

SMALL = Order("Somebody", lens="50lpi", size_mm=(90.0, 110.0), range_m=(0.5, 0.9))
OPTIONS = ["--size", "90x110", "--range", "0.5-0.9"]


def listed(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def run(people: Path, out: Path, *more: str) -> Result:
    return CliRunner().invoke(moireid, ["print", "--people", str(people), "--out", str(out), *OPTIONS, *more])


#: Boards that fill their paper, and how many of them are on it.
FULL = [
    ("a4", (90.0, 110.0), (0.5, 0.9), 4),
    ("letter", (60.0, 80.0), (0.3, 1.0), 9),
    ("a4", (180.0, 267.0), (0.8, 2.5), 1),
]


@pytest.mark.slow
@pytest.mark.parametrize(("paper", "size", "metres", "count"), FULL)
def test_full_sheets_have_both_scale_bars_clear_of_all_else(paper, size, metres, count, tmp_path):
    """Catches: sheets that show a printer's scale in one direction alone; bars on boards or among crop marks; a
    second sheet without bars; boards lost for room not needed."""
    wish = Order("A", lens="50lpi", size_mm=size, range_m=metres, paper=paper)
    badges = [design_badge(wish, bytes([k]) * 8) for k in range(count + 1)]
    assert write_sheets_pdf(badges, tmp_path / "badges.pdf") == (2, count)
    boards = [(x, y, x + size[0], y + size[1]) for x, y in lay_out_sheets(badges[0]).places_mm]
    for number, shown in ((0, boards), (1, boards[:1])):
        strokes = geometry(tmp_path / "badges.pdf", number).strokes
        spans = [(min(ax, bx), min(ay, by), max(ax, bx), max(ay, by)) for ax, ay, bx, by in strokes]
        (level,) = [s for s in spans if s[2] - s[0] == pytest.approx(150, abs=1e-3)]
        (upright,) = [s for s in spans if s[3] - s[1] == pytest.approx(150, abs=1e-3)]
        bars = [(*level[:3], level[3] + 3), (upright[0] - 3, *upright[1:])]
        gaps = [[max(b[0] - s[2], s[0] - b[2], b[1] - s[3], s[1] - b[3]) for b in bars] for s in spans]
        # What is not of a bar is a crop mark, and keeps half a millimetre off both.
        marks = [s for s, gap in zip(spans, gaps, strict=True) if min(gap) > 0.01]
        assert len(marks) == 8 * len(shown) and min(min(gap) for gap in gaps if min(gap) > 0.01) > 0.4
        assert all(max(x1 - x0, y1 - y0) >= 1.9 for x0, y0, x1, y1 in marks)
        for x0, y0, x1, y1 in spans:
            assert all(x1 <= b[0] or x0 >= b[2] or y1 <= b[1] or y0 >= b[3] for b in boards)


def test_every_board_is_on_the_sheets_once(tmp_path):
    """Catches: the last sheet left out, a board drawn twice, markers of a board off its place."""
    badges = [design_badge(replace(SMALL, name=f"Person {k}"), payload_for_name(f"Person {k}")) for k in range(6)]
    assert write_sheets_pdf(badges, tmp_path / "badges.pdf") == (2, 4)
    document = pdfium.PdfDocument(tmp_path / "badges.pdf")
    assert len(document) == 2
    texts = [page.get_textpage().get_text_range() for page in document]
    for k, badge in enumerate(badges):
        assert sum(text.count(f"moireid {badge.id}") for text in texts) == 1 and f"Person {k}" in texts[k // 4]
    finder = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    for page, boards in zip(document, (4, 2), strict=True):
        picture = np.asarray(page.render(scale=2, grayscale=True).to_pil())
        corners, ids, _ = finder.detectMarkers(picture)
        assert sorted(np.ravel(ids).tolist()) == sorted([0, 1, 2, 3] * boards)
        middles = {tuple(np.round(quad.reshape(4, 2).mean(axis=0) / 2 * 25.4 / 72).astype(int)) for quad in corners}
        for left, top in lay_out_sheets(badges[0]).places_mm[:boards]:
            for x, y in badges[0].markers.centers_mm:
                place = left + x - badges[0].outline_mm[0], top + y - badges[0].outline_mm[1]
                assert any(abs(place[0] - mx) <= 1 and abs(place[1] - my) <= 1 for mx, my in middles)
    document.close()
    with pytest.raises(FabricationError, match="one size"):
        write_sheets_pdf([badges[0], design_badge(Order("A", lens="50lpi"), bytes(8))], tmp_path / "mixed.pdf")
    assert not (tmp_path / "mixed.pdf").exists()


def test_the_command_makes_folders_summary_and_records(tmp_path, monkeypatch):
    """Catches: people in another order, a payload column that is not read, records of some of them only."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    people = listed(tmp_path / "people.csv", "\ufeffName, payload\nZoë,\nAda,0f5ac3962d784be1\n\nßÄ/..,\n")
    url = f"sqlite:///{tmp_path}/r.sqlite3"
    outcome = run(people, tmp_path / "event", "--registry", url, "--json")
    assert outcome.exit_code == 0, outcome.output
    document = json.loads(outcome.stdout)
    assert [one["name"] for one in document["people"]] == ["Zoë", "Ada", "ßÄ/.."]
    assert document["people"][1]["id"] == "0f5ac3962d784be1" and document["sheets"] == 1
    summary = list(csv.DictReader((tmp_path / "event" / "summary.csv").open(encoding="utf-8-sig")))
    assert (tmp_path / "event" / "summary.csv").read_bytes().startswith(BOM_UTF8)
    assert [row["name"] for row in summary] == ["Zoë", "Ada", "ßÄ/.."]
    with open_registry(url, create=False) as registry:
        for row in summary:
            folder = tmp_path / "event" / row["folder"]
            badge = load_badge(folder / "badge.json")
            assert badge.id == row["id"] and registry.find(row["name"]).badge == badge
            assert {path.name for path in folder.iterdir()} == {
                "badge.pdf",
                "badge.json",
                "preview.png",
            }
    # One sheet shows all how to build theirs, and bears no one's name.
    guide = pdfium.PdfDocument(tmp_path / "event" / "assembly.pdf")
    words = " ".join(page.get_textpage().get_text_range() for page in guide)
    assert len(guide) == 3 and "these badges" in words and "summary.csv" in words
    assert not any(row["name"] in words or row["id"] in words for row in summary)
    guide.close()
    again = run(people, tmp_path / "event", "--registry", url)
    assert again.exit_code == 2 and "--overwrite" in again.stderr


def test_the_mask_of_an_event_is_no_single_badges(tmp_path):
    """Catches: one person's id on the film that all get, and an organiser who prints one film for many."""
    people = listed(tmp_path / "people.csv", "name\nAda\nGrace\nEve\n")
    outcome = run(people, tmp_path / "event", "--front", "mask")
    assert outcome.exit_code == 0 and "print it 3 times" in outcome.output and "One mount" not in outcome.output
    words = pdfium.PdfDocument(tmp_path / "event" / "badges.pdf")[1].get_textpage().get_text_bounded()
    assert "Mask of 3 badges: print 3 times" in words and "page 1" not in words
    alone = pdfium.PdfDocument(tmp_path / "event" / "001-ada" / "badge.pdf")[1].get_textpage().get_text_bounded()
    assert "Mask of moiré badge" in alone and "page 1" in alone
