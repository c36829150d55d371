"""Names of any script on the page, in the preview and in an event's folders."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.event import folder_name, print_event
from moireid.fabrication.mount_parts import plan_parts
from moireid.fabrication.page import lettering
from moireid.fabrication.page.lettering import name_note, set_name
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.fabrication.text import fonts
from moireid.fabrication.text.shaping import shape_line

#: No font has these: private use and a script of no living writer.
NOWHERE = "\U000e0f00\U0001f9ff"


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi"), bytes(range(8)))


@pytest.fixture
def only_own_font(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine that has no fonts of its own."""
    for cached in (lettering.set_name, shape_line):
        cached.cache_clear()
    monkeypatch.setattr(fonts, "system_fonts", lambda bold: ())
    monkeypatch.setattr(fonts, "_found", {})
    yield
    for cached in (lettering.set_name, shape_line):
        cached.cache_clear()


def between_markers(badge: Badge, folder: Path) -> tuple[np.ndarray, str]:
    """The page between the upper markers at 300 dpi, grey, and its words."""
    write_badge_pdf(badge, folder / "n.pdf")
    document = pdfium.PdfDocument(folder / "n.pdf")
    picture = np.asarray(document[0].render(scale=300 / 72, grayscale=True).to_pil())
    words = document[0].get_textpage().get_text_range()
    document.close()
    (x0, y), (x1, _) = badge.markers.centers_mm[:2]
    half = badge.markers.size_mm / 2
    box = [round(v / 25.4 * 300) for v in (x0 + half + 1, y - half, x1 - half - 1, y + half)]
    return picture[box[1] : box[3], box[0] : box[2]], words


@pytest.mark.parametrize("name", ["محمد بن سلمان", "שלום", "Ada Łukasz", "x̂ ỹ", "श्री"])
def test_a_name_of_any_script_is_text_between_the_markers(
    badge: Badge, name: str, only_own_font: None, tmp_path: Path
) -> None:
    """Catches: the id in place of a name that could be set; a name as a picture; letters over the markers."""
    named = replace(badge, name=name)
    assert name_note(name) is None
    drawn, words = between_markers(named, tmp_path)
    assert words.count(f"moireid {badge.id}") == 1 and name in words
    dark = drawn < 128
    assert 0.005 < dark.mean() < 0.3 and not dark[:20].any() and not dark[:, :10].any() and not dark[:, -10:].any()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Ada \U0001f469\u200d\U0001f4bb Lovelace", "Ada Lovelace"),
        ("Ada 山田", "Ada"),
        ("محمد \U0001f389", "محمد"),
        (f"{NOWHERE}Zoë \U0001f1eb\U0001f1f7\ufe0f", "Zoë"),
    ],
)
def test_what_no_font_has_is_left_out_and_reported(
    badge: Badge, name: str, words: str, only_own_font: None, tmp_path: Path
) -> None:
    """Catches: boxes, the id in a name's place, joiners that stay behind, a name cut without a word."""
    note = name_note(name)
    assert set_name(name)[0] == words and note is not None and repr(name) in note and repr(words) in note
    drawn, said = between_markers(replace(badge, name=name), tmp_path)
    plain, _ = between_markers(replace(badge, name=words), tmp_path)
    assert (drawn == plain).all() and badge.id is not None and said.count(badge.id) == 1


@pytest.mark.parametrize("name", ["山田太郎", "\U0001f389\U0001f469\u200d\U0001f4bb", "\U0001f389 -"])
def test_a_name_of_which_nothing_is_left_is_refused(
    badge: Badge, name: str, only_own_font: None, tmp_path: Path
) -> None:
    """Catches: a badge that bears an id, a dash or nothing in place of its name."""
    for refuse in (lambda: name_note(name), lambda: between_markers(replace(badge, name=name), tmp_path)):
        with pytest.raises(FabricationError, match="shows nothing of it"):
            refuse()


def test_names_from_a_list_make_safe_and_distinct_folders(tmp_path: Path) -> None:
    """Catches: a name that leaves the folder; two people in one folder; folders that sort unlike the list."""
    names = [
        "..",
        "../../etc/passwd",
        "CON",
        "Ada",
        "ADA",
        "Ada.",
        "a/b",
        "a\\b",
        "李",
        "李明",
        "~",
        "-rf",
        "محمد",
        "😀",
        "Þóra Łukasz",
    ]
    base = Order("Somebody", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.3, 1.0))
    badges = [design_badge(replace(base, name=name), bytes([k + 1]) * 8) for k, name in enumerate(names)]
    event = print_event(badges[:3], tmp_path / "event", parts=plan_parts(badges[0], "none"))
    assert {path.name for path in tmp_path.iterdir()} == {"event"}
    assert all(path.parent == tmp_path / "event" and path.is_dir() for path in event.folders)
    folders = [folder_name(number, one, 2) for number, one in enumerate(badges, 1)]
    assert len({folder.casefold() for folder in folders}) == len(names) and folders == sorted(folders)
    assert all(set(folder) <= set("abcdefghijklmnopqrstuvwxyz0123456789-") for folder in folders)
    assert (folder_name(7, badges[3], 5), folders[-1]) == ("00007-ada", "15-thora-lukasz")
