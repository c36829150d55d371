"""Logos and portraits: what is drawn, and what is refused before it costs time or reaches out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from moireid.artwork import svg as drawn
from moireid.artwork.content import content_of
from moireid.artwork.pictures import MOST_SIDE_PX, as_portrait, load_picture
from moireid.errors import SpecError

NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'


def svg(folder: Path, inside: str, *, head: str = "", box: str = "0 0 200 100") -> Path:
    path = folder / "logo.svg"
    path.write_text(f'{head}<svg {NS} viewBox="{box}">{inside}</svg>', encoding="utf-8")
    return path


def test_an_svg_is_drawn_in_its_shape_and_colours(tmp_path: Path) -> None:
    """Catches: a logo stretched, cut, on a ground of its own, or with the colours of its channels exchanged."""
    inside = '<rect width="100" height="100" fill="#c01020"/><circle cx="150" cy="50" r="50" fill="#1020c0"/>'
    picture = load_picture(svg(tmp_path, inside), "logo")
    assert picture.size == (MOST_SIDE_PX, MOST_SIDE_PX // 2)
    pixels = np.asarray(picture)
    assert pixels[500, 500].tolist() == [0xC0, 0x10, 0x20, 255]
    assert pixels[500, 1500].tolist() == [0x10, 0x20, 0xC0, 255]
    # Outside the circle there is nothing.
    assert pixels[10, 1990, 3] == 0


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<script>1</script>", "holds a script"),
        ("<text>Press</text>", "turn text into paths"),
        ('<image href="/etc/hostname" width="9" height="9"/>', "a picture within"),
        ('<use href="other.svg#a"/>', "outside of itself"),
        ('<rect width="9" height="9" fill="url(http://example.org/a.svg#b)"/>', "outside of itself"),
        ("<style>@import url(http://example.org/a.css);</style>", "outside of itself in its style"),
        ('<rect width="9" height="9" onclick="alert(1)"/>', "outside of itself"),
        ('<foreignObject><body xmlns="http://www.w3.org/1999/xhtml"/></foreignObject>', "a page of another kind"),
        ('<filter id="f"><feGaussianBlur stdDeviation="9"/></filter>', "flatten"),
        ('<rect width="9" height="9" filter="blur(9)"/>', "holds a filter"),
        ('<rect width="9" height="9" style="marker: none; filter : blur(9)"/>', "holds a filter"),
        ("<style>rect { mask: url(#a) }</style>", "mask or marker in its style"),
        ('<marker id="a"/>', "turn strokes into paths"),
        ('<pattern id="a"/>', "holds patterns"),
        ('<mask id="a"/>', "holds masks"),
        ("<g>" * 400 + "</g>" * 400, "nested deeper"),
        ("<rect", "is no SVG"),
    ],
)
def test_what_a_logo_may_not_hold_is_refused(tmp_path: Path, inside: str, message: str) -> None:
    """Catches: an untrusted file that runs code, opens addresses, reads files next to it, or is drawn for hours."""
    with pytest.raises(SpecError, match=message):
        load_picture(svg(tmp_path, inside), "logo")


def test_copies_of_copies_and_entities_are_refused(tmp_path: Path) -> None:
    """Catches: a few hundred bytes that are drawn as millions of shapes."""
    levels = [f'<g id="a{k}">' + f'<use xlink:href="#a{k - 1}"/>' * 10 + "</g>" for k in range(1, 9)]
    with pytest.raises(SpecError, match="more than 20000 shapes"):
        load_picture(svg(tmp_path, '<g id="a0"><rect width="9" height="9"/></g>' + "".join(levels)), "logo")
    with pytest.raises(SpecError, match="nested deeper"):
        load_picture(svg(tmp_path, '<g id="a"><use href="#a"/></g>'), "logo")
    head = '<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>'
    with pytest.raises(SpecError, match="entities"):
        load_picture(svg(tmp_path, "<title>&b;</title>", head=head), "logo")
    for box in ("0 0 9000 1", "0 0 . 5", "0 0 1e999 1e999"):
        with pytest.raises(SpecError, match="no size of a logo"):
            load_picture(svg(tmp_path, "<g/>", box=box), "logo")
    cuts = [f'<clipPath id="a{k}">' + f'<g clip-path="url(#a{k - 1})"/>' * 10 + "</clipPath>" for k in range(1, 9)]
    with pytest.raises(SpecError, match="more than 20000 shapes"):
        load_picture(svg(tmp_path, '<clipPath id="a0"/>' + "".join(cuts)), "logo")


def test_what_takes_long_to_draw_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: layers or a pattern of checks that hold the program for hours."""
    # A pattern that backtracks takes minutes for this comment.
    assert load_picture(svg(tmp_path, f'<!--{"<!DOCTYPE " * 100_000}--><path d="M0 0h9v9z"/>'), "logo").width
    monkeypatch.setattr(drawn, "MOST_SECONDS", 0.3)
    layers = '<g opacity=".9"><rect width="90" height="90"/><rect width="9" height="9"/></g>' * 400
    with pytest.raises(SpecError, match=r"more than 0\.3 s to draw; simplify it"):
        load_picture(svg(tmp_path, layers), "logo")


def test_photographs_are_upright_small_and_cut_to_a_portrait(tmp_path: Path) -> None:
    """Catches: a phone's photograph on its side, one that is kept at full size, and a face that is cut off."""
    tall = Image.new("RGB", (3000, 4000), "white")
    tall.paste("red", (0, 0, 3000, 400))
    exif = tall.getexif()
    exif[0x0112] = 6  # The camera was turned: its rows are columns.
    tall.rotate(90, expand=True).save(tmp_path / "a.jpg", exif=exif)
    found = load_picture(tmp_path / "a.jpg", "portrait")
    assert found.size == (1500, 2000)
    assert np.asarray(found)[20, 700, :3] == pytest.approx([254, 0, 0], abs=8)
    wide, high = as_portrait(found.resize((400, 1000))).size
    assert wide / high == pytest.approx(0.8, abs=0.01)
    assert as_portrait(found.resize((1000, 400))).size == (320, 400)


def test_colours_are_hex_or_css(tmp_path: Path) -> None:
    """Catches: a colour that is guessed."""
    assert content_of(colour="#134e8c").colour == pytest.approx((0x13 / 255, 0x4E / 255, 0x8C / 255))
    assert content_of(colour="Teal").colour == pytest.approx((0, 128 / 255, 128 / 255))
    with pytest.raises(SpecError, match="'tael' is not known; give six hex digits"):
        content_of(colour="tael")
    for wrong in ("rgb(200%,0%,0%)", "rgb(999,0,0)", "hsl(0,300%,50%)", "#0a7d6e00"):
        with pytest.raises(SpecError, match="is not known"):
            content_of(colour=wrong)
