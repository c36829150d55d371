"""Where pieces are placed: never over what is read, nor over each other, on any badge that a template can serve."""

from __future__ import annotations

import itertools
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from kit.set_rows import box_mm
from moireid.artwork.clear import GRATING_MM, MARKER_MODULES, clear_zones
from moireid.artwork.columns import dressed, files_below
from moireid.artwork.content import Artwork, with_lines
from moireid.artwork.pictures import modules_of
from moireid.artwork.placing import ArtPiece, Look, pieces_of
from moireid.artwork.template import TEMPLATES, BadgeTemplate, template_named, template_of
from moireid.badge import Badge, Rect
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS, ORIENTATIONS, turned
from moireid.errors import SpecError
from moireid.fabrication.page.page_words import set_words
from moireid.verifier.tracking.borders import REACH_MM
from moireid.verifier.tracking.print_template import FREE_MODULES

PAYLOAD = bytes.fromhex("7097c67b0fafc59b")
LINES = ("Reporter · Example News", "Accredited until 31 Dec 2026")


def badge_for(template: BadgeTemplate, name: str, orientation: str, payload: bytes = PAYLOAD) -> Badge:
    side = template.side(*turned(FORMATS[name].size_mm, orientation))
    order = Order("Ada Lovelace", format=name, orientation=orientation, head=side.head, foot=side.foot)
    return design_badge(order, payload)


def overlap(one: Rect, other: Rect) -> bool:
    return all(one[k] < other[k + 2] - 1e-6 and other[k] < one[k + 2] - 1e-6 for k in (0, 1))


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("template", TEMPLATES)
def test_every_template_leaves_clear_what_is_read_on_every_format(template: str, name: str, content: Artwork) -> None:
    """Catches: artwork over a marker's white, the fringes or the sheet; pieces over each other; words without room."""
    known = template_named(template)
    for orientation, lines in itertools.product(ORIENTATIONS, ((), LINES[:1], LINES)):
        badge = with_lines(badge_for(known, name, orientation), lines)
        zones = [zone for _, zone in clear_zones(badge)]
        for worn in (Artwork(), content, replace(content, portrait=None), replace(content, logo=None)):
            pieces = pieces_of(badge, Look(known, worn))
            for piece in pieces:
                assert not any(overlap(piece.rect_mm, zone) for zone in zones), (orientation, piece)
                if piece.kind in ("words", "id"):
                    assert_within(piece, badge)
            fore = [piece.rect_mm for piece in pieces if piece.kind != "ground"]
            assert not any(overlap(a, b) for a, b in itertools.combinations(fore, 2)), (orientation, worn)
            assert any(piece.name for piece in pieces)


def assert_within(piece: ArtPiece, badge: Badge) -> None:
    """All rows lie in the piece's room, in letters that can be read."""
    x0, y0, x1, y1 = piece.rect_mm
    for row in set_words(piece, badge.id):
        left, _, right, _ = box_mm(row)
        assert x0 - 1e-6 <= left and right <= x1 + 1e-6
        assert y0 - 1e-6 <= row.baseline_mm - 0.73 * row.points / 72 * 25.4 and row.baseline_mm <= y1 + 1e-6
        assert row.points >= (piece.least_points if piece.kind == "words" else 2.5) - 1e-9


def test_what_must_stay_clear_is_what_the_verifier_reads() -> None:
    """Catches: a verifier that samples more than the pages leave white."""
    assert (MARKER_MODULES, GRATING_MM) == (FREE_MODULES, REACH_MM)


def test_a_template_that_covers_what_is_read_is_refused() -> None:
    """Catches: a ground from side to side that spoils the badge in silence."""
    for area, fault in (("head", "covers the upper left marker and its white border"), ("upper", None)):
        place = {"what": "name", "area": area, "ground": "tint", "bleed": True}
        own = template_of({"landscape": {"head": 0.45, "place": [place]}}, "own")
        with pytest.raises(SpecError, match=fault) if fault else nullcontext():
            assert pieces_of(badge_for(own, "a6", "landscape"), Look(own, Artwork()))


@pytest.mark.parametrize("what", [["qr"] * 60, ["name", *["qr"] * 9], ["name"] * 40])
def test_more_pieces_than_a_place_has_room_for_are_refused(what: list[str]) -> None:
    """Catches: pieces of less than no width, which are drawn mirrored over the markers."""
    own = template_of({"landscape": {"head": 0.3, "foot": 0.3, "place": [{"what": what, "area": "head"}]}}, "own")
    with pytest.raises(SpecError, match=f"has no room for {len(what)} pieces side by side"):
        pieces_of(badge_for(own, "a6", "landscape"), Look(own, Artwork()))


@pytest.mark.parametrize("apart", [False, True])
def test_a_qr_code_on_a_colour_has_white_around_it(apart: bool) -> None:
    """Catches: a code whose edge runs into a dark ground, its place's own or that of a place below it."""
    band, code = {"area": "foot", "ground": "accent"}, {"what": "qr", "area": "foot"}
    places = [band, code] if apart else [band | code]
    own = template_of({"landscape": {"head": 0.3, "foot": 0.3, "place": places}}, "own")
    badge = badge_for(own, "a6", "landscape")
    *_, white, drawn = pieces_of(badge, Look(own, Artwork()))
    assert (white.kind, white.colour, drawn.kind) == ("ground", (1.0, 1.0, 1.0), "qr")
    module = (drawn.rect_mm[2] - drawn.rect_mm[0]) / len(modules_of(badge.id or ""))
    signs = (-1, -1, 1, 1)
    assert [sign * (b - a) / module for sign, a, b in zip(signs, drawn.rect_mm, white.rect_mm, strict=True)] == (
        pytest.approx([4.0] * 4)
    )


def test_a_list_names_no_file_outside_of_its_folder(content: Artwork, tmp_path: Path) -> None:
    """Catches: somebody else's list that prints a private file of this machine on a badge."""
    assert content.logo is not None
    look = Look(template_named("plain"), Artwork())
    badge = badge_for(look.template, "a7", "landscape")
    (tmp_path / "link.png").symlink_to(content.logo)
    (tmp_path / "round.png").symlink_to(tmp_path / "round.png")
    for cell in (str(content.logo), f"../{tmp_path.name}/a.png", "link.png", "round.png"):
        with pytest.raises(SpecError, match=r"is not below the list's folder; put it there"):
            dressed(badge, {"logo": cell}, look, [], files_below(tmp_path))
    (tmp_path / "logo.png").write_bytes(content.logo.read_bytes())
    (tmp_path / "link.png").unlink()
    (tmp_path / "link.png").symlink_to("logo.png")
    assert dressed(badge, {"logo": "link.png"}, look, [], files_below(tmp_path)).look is not None
