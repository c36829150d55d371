"""What was given and is not shown is reported, and nothing else.  Each test names the fault that it catches."""

from __future__ import annotations

import pytest

from moireid.artwork.colours import tint
from moireid.artwork.content import Artwork
from moireid.artwork.placing import Look, pieces_of, unworn
from moireid.artwork.template import TEMPLATES, template_named
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.formats import ORIENTATIONS


def badge_for(look: Look, orientation: str) -> Badge:
    side = look.template.side(*((148.0, 105.0) if orientation == "landscape" else (105.0, 148.0)))
    order = Order("Ada Lovelace", format="a6", orientation=orientation, head=side.head, foot=side.foot)
    return design_badge(order, bytes(8))


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
