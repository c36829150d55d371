"""Names of any script on the page, in the preview and in an event's folders."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pytest

from moireid.artwork.placing import ArtPiece
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError, SpecError
from moireid.fabrication.event import folder_name, print_event
from moireid.fabrication.page import lettering, preview
from moireid.fabrication.page.lettering import name_note, set_name
from moireid.fabrication.page.page_words import set_words
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
    assert set_name(name).words == words and note is not None and repr(name) in note and repr(words) in note
    drawn, said = between_markers(replace(badge, name=name), tmp_path)
    plain, _ = between_markers(replace(badge, name=words), tmp_path)
    assert (drawn == plain).all() and badge.id is not None and said.count(badge.id) == 1


@pytest.mark.parametrize("name", ["山田太郎", "\U0001f389\U0001f469\u200d\U0001f4bb", "\U0001f389 -"])
def test_a_name_of_which_nothing_is_left_is_refused(
    badge: Badge, name: str, only_own_font: None, tmp_path: Path
) -> None:
    """Catches: a badge that bears an id, a dash or nothing in place of its name."""
    for refuse in (lambda: name_note(name), lambda: between_markers(replace(badge, name=name), tmp_path)):
        with pytest.raises(FabricationError, match="no font on this machine has a letter"):
            refuse()


def test_the_preview_shows_the_name_as_the_page_does(badge: Badge, only_own_font: None) -> None:
    """Catches: a preview that promises another name than is printed."""
    pictures = [
        np.asarray(preview.draw_preview(replace(badge, name=name))) for name in ("محمد", "שלום", "Bo 山田", "Bo 李")
    ]
    top = [picture[60:160, 200:-200] for picture in pictures]
    assert (top[0] != top[1]).any() and (top[1] != top[2]).any() and (top[2] == top[3]).all()
    assert all((picture < 100).any() for picture in top)


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
    ]
    base = Order("Somebody", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.3, 1.0))
    badges = [design_badge(replace(base, name=name), bytes([k + 1]) * 8) for k, name in enumerate(names)]
    event = print_event(badges[:3], tmp_path / "event")
    assert {path.name for path in tmp_path.iterdir()} == {"event"}
    assert all(path.parent == tmp_path / "event" and path.is_dir() for path in event.folders)
    folders = [folder_name(number, one) for number, one in enumerate(badges, 1)]
    assert len({folder.casefold() for folder in folders}) == len(names) and folders == sorted(folders)
    assert all(set(folder) <= set("abcdefghijklmnopqrstuvwxyz0123456789-") for folder in folders)
    assert folder_name(7, badges[3], 5) == "00007-ada"


@pytest.mark.slow
def test_the_same_name_gives_the_same_bytes_in_another_process(badge: Badge, tmp_path: Path) -> None:
    """Catches: a font or a layout that depends on the order of a set or of a folder's files."""
    code = (
        "import sys; from pathlib import Path; from dataclasses import replace\n"
        "from moireid.designer import Order, design_badge\n"
        "from moireid.fabrication.page.pdf import write_badge_pdf\n"
        "badge = replace(design_badge(Order('Ada Lovelace', lens='50lpi'), bytes(range(8))), name='محمد बि 山')\n"
        "write_badge_pdf(badge, Path(sys.argv[1]))\n"
    )
    for number, seed in enumerate("01"):
        command = [sys.executable, "-c", code, str(tmp_path / f"{number}.pdf")]
        subprocess.run(command, check=True, env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path)})
    assert (tmp_path / "0.pdf").read_bytes() == (tmp_path / "1.pdf").read_bytes()


#: Marks that stack above and below a letter.
STACKED = "Zoe" + "\u0301\u0323" * 15 + "d"


@pytest.mark.parametrize("name", [STACKED, "A" + "\u0323" * 12 + "da", "مُحَمَّدٌ", "שָׁלוֹם עוֹלָם"])
def test_signs_above_and_below_letters_stay_in_their_room(name: str) -> None:
    """Catches: marks that are stacked over the fringes, over the line below, or beyond the board's edge."""
    piece = ArtPiece("words", (10.0, 10.0, 90.0, 22.0), name=name, lines=("Reporter",))
    if name.count("\u0323") > 3:
        with pytest.raises(SpecError, match="has no room on this badge"):
            set_words(piece, None)
        return
    boxes = [row.box_mm for row in set_words(piece, None)]
    for x0, y0, x1, y1 in boxes:
        assert 10.0 - 1e-6 <= x0 < x1 <= 90.0 + 1e-6 and 10.0 - 1e-6 <= y0 < y1
    assert boxes[0][3] <= boxes[1][1] + 1e-6 and boxes[-1][3] <= 22.0 + 1e-6


@pytest.mark.parametrize("form", ["cr80", "a7", "4x3in", "a6", "board"])
def test_the_words_of_a_mask_s_page_keep_clear_of_its_lines(form: str, tmp_path: Path) -> None:
    """Catches: instructions that are printed on the film's lines, which spoils it."""
    badge = design_badge(Order("Ada", front="mask", format=form, orientation="landscape"), bytes(8))
    write_badge_pdf(badge, tmp_path / "a.pdf")
    document = pdfium.PdfDocument(tmp_path / "a.pdf")
    words, height = document[1].get_textpage(), document[1].get_height()
    boxes = [words.get_charbox(k) for k in range(words.count_chars())]
    document.close()
    tops = [(height - box[3]) * 25.4 / 72 for box in boxes]
    lows = [(height - box[1]) * 25.4 / 72 for box in boxes]
    first, last = (f(badge.bounds_of(g)[k] for g in badge.gratings) for f, k in ((min, 1), (max, 3)))
    assert all(low < first - 1.0 or top > last for top, low in zip(tops, lows, strict=True)) and min(tops) > 0
