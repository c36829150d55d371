"""Which mount a format gets.  Each test states what it would catch."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import in_format
from moireid.errors import FabricationError
from moireid.fabrication.process_figures import MountFigures, mount_figures
from moireid.issuing import Wear

CARD = Wear("cr80", "portrait", None, None, None, None, (), None, None, None)


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(in_format(Request("Ada Lovelace"), "cr80", orientation="portrait"), bytes(8))


def test_a_format_gets_a_holder_where_the_mount_asked_for_does_not_fit(badge: Badge) -> None:
    """Catches: a refusal or a note alone where a holder can be made; a holder in place of a mount that fits."""
    parts, note = CARD.parts(badge, "stand", MountFigures())
    assert parts.printed == "holder"
    assert note == "no printed mount of the kind stand fits cr80; a snap-in holder is made instead"
    for wish in (None, "lanyard", "holder", "none"):
        parts, note = CARD.parts(badge, wish, MountFigures())
        assert (parts.printed, note) == (wish or "lanyard", None)


def test_a_figure_that_was_given_is_an_order(badge: Badge) -> None:
    """Catches: another mount than the one whose figure was set; a board of its own that is given a holder unasked."""
    with pytest.raises(FabricationError, match="front wall"):
        CARD.parts(badge, "stand", mount_figures(["stand_deg=20"]))
    with pytest.raises(FabricationError, match="front wall"):
        replace(CARD, format_name=None).parts(badge, "stand", MountFigures())
