"""What was given and is not shown is reported, and nothing else.  Each test names the fault that it catches."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.artwork.colours import tint
from moireid.artwork.content import Artwork, with_lines
from moireid.artwork.placing import Look, pieces_of, unworn
from moireid.artwork.template import TEMPLATES, template_named, template_of
from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import ORIENTATIONS, in_format
from moireid.designer.request import FringeBorder


def badge_for(look: Look, orientation: str) -> Badge:
    side = look.template.side(*((148.0, 105.0) if orientation == "landscape" else (105.0, 148.0)))
    wish = replace(Request("Ada Lovelace"), frame=FringeBorder(head=side.head, foot=side.foot))
    return design_badge(in_format(wish, "a6", orientation=orientation), bytes(8))


@pytest.mark.parametrize("orientation", ORIENTATIONS)
@pytest.mark.parametrize("name", TEMPLATES)
def test_each_picture_is_shown_or_reported(name: str, orientation: str, content: Artwork) -> None:
    """Catches: a picture that is lost without a word, or called lost though it is there."""
    look = Look(template_named(name), content)
    badge = badge_for(look, orientation)
    shown = [piece for piece in pieces_of(badge, look) if piece.kind == "picture"]
    notes = unworn(badge, look)
    lost = [what for what in ("logo", "portrait") if any(f"shows no {what}" in note for note in notes)]
    assert len(shown) + len(lost) == 2
    colours = {piece.colour for piece in pieces_of(badge, look) if piece.kind == "ground"}
    assert colours & {look.accent, tint(look.accent)} or any("the colour is not used" in note for note in notes)
    assert unworn(badge, Look(look.template, Artwork())) == []


def test_a_template_that_shows_it_is_named(content: Artwork) -> None:
    """Catches: advice that leads to another template without the piece."""
    look = Look(template_named("conference"), content)
    (note,) = [note for note in unworn(badge_for(look, "portrait"), look) if "portrait" in note]
    assert note.startswith("the template conference shows no portrait, so it is left out; plain, newsroom, banner, ")
    assert note.endswith("campus, minimal, stripes and gala show one")


def test_a_line_that_has_no_place_is_reported() -> None:
    """Catches: a second line that a template with room for one alone swallows."""
    places = [{"what": "name", "area": "head"}, {"what": "line1", "area": "foot"}]
    template = template_of({"landscape": {"head": 0.3, "foot": 0.2, "place": places}}, "ours.toml")
    look = Look(template, Artwork())
    badge = with_lines(badge_for(look, "landscape"), ("Keynote", "Analytical Engines"))
    assert unworn(badge, look) == [
        "the template ours.toml does not show the line 'Analytical Engines'",
        "the template ours.toml does not show the identity, so only badge.json states which badge this is",
    ]


def test_a_colour_counts_as_shown_only_where_something_is_coloured() -> None:
    """Catches: a place that would be coloured if the person had its pieces."""
    places = [{"what": ["name", "line1"], "area": "head"}, {"what": ["qr", "id"], "area": "foot"}]
    template = template_of({"landscape": {"head": 0.3, "foot": 0.2, "place": places}}, "ours.toml")
    look = Look(template, Artwork(colour=(1.0, 0.0, 0.0)))
    badge = badge_for(look, "landscape")
    assert unworn(badge, look) == ["the template ours.toml has nothing in colour, so the colour is not used"]
    assert unworn(with_lines(badge, ("Keynote",)), look) == []
