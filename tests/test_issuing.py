"""From an order to a plan, and which mount a format gets.  Next to each test: the wrong implementation it catches."""

from __future__ import annotations

import random
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.designer.design import filled
from moireid.errors import DesignError, FabricationError, RegistryError
from moireid.issuing import choose_parts, draw, plan_badge

PLAIN = Order("Ada Lovelace", lines=["Reporter"], mount="none")


CARD = Order("Ada Lovelace", format="cr80", orientation="portrait")


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(CARD, bytes(8))


def test_a_mount_that_does_not_fit_is_refused_if_it_was_asked_for_and_else_left_out(badge: Badge) -> None:
    """Catches: another mount than the one asked for; a refusal of a format for a mount that no one asked for."""
    masked = replace(CARD, front="mask", orientation="landscape")
    card = design_badge(masked, bytes(8))
    with pytest.raises(FabricationError, match="no mount can be made"):
        choose_parts(card, replace(masked, mount="lanyard"))
    parts, note = choose_parts(card, masked)
    assert (parts.printed, note) == ("none", "no mount is made for cr80; the badge goes into a card holder")
    for wish in (None, "lanyard", "none"):
        parts, note = choose_parts(badge, replace(CARD, mount=wish))
        assert (parts.printed, note) == (wish or "lanyard", None)


def test_a_figure_that_was_given_is_an_order(badge: Badge) -> None:
    """Catches: another mount than the one whose figure was set; a badge that is refused its acrylic stack."""
    with pytest.raises(FabricationError, match="front wall"):
        choose_parts(badge, replace(CARD, mount="stand", mount_mm={"stand_deg": 20.0}))
    # The acrylic stack can be made.
    parts, note = choose_parts(badge, replace(CARD, mount="stand"))
    assert (parts.printed, note) == ("none", None) and parts.acrylic and "front wall" in parts.left_out["printed"]


# Identities that are drawn.


def test_a_name_makes_no_identity() -> None:
    """Catches: an identity that a name, a seed or the clock gives, with which anybody could print the badge."""
    random.seed(1)
    np.random.seed(1)  # noqa: NPY002 - a seed that somebody sets must change nothing
    first, _ = draw(filled(Order("Ada Lovelace")), None)
    random.seed(1)
    np.random.seed(1)  # noqa: NPY002
    second, _ = draw(filled(Order("Ada Lovelace")), None)
    assert first.id != second.id and first.name == second.name


def test_an_identity_is_as_long_as_its_place_asks() -> None:
    """Catches: 64 bits where no registry looks for twins, 128 that the range cannot carry, a length without a note."""
    long, note = draw(Order("A"), None)
    assert (long.payload_bits, note) == (128, None)
    short, note = draw(Order("A", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.3, 1.6)), None)
    assert short.payload_bits == 64 and note is not None and "64 bits" in note
    known, note = draw(Order("A"), lambda _: None)
    assert (known.payload_bits, note) == (64, None)
    assert draw(Order("A", lens="50lpi", code="pitch"), None)[0].payload_bits == 24
    with pytest.raises(DesignError):
        draw(Order("A", range_m=(0.8, 30.0)), None)


@dataclass(frozen=True)
class Held:
    """Somebody's record."""

    badge: Badge
    name: str = "Bob"
    issued_at: str = "2026-01-31T12:00:00Z"
    revoked_at: str | None = None
    revoked_reason: str | None = None


def test_what_somebody_holds_is_drawn_anew(badge: Badge) -> None:
    """Catches: an identity that is issued twice, and a loop without end where none is free."""
    asked: list[str] = []

    def taken_twice(badge_id: str) -> Any:
        asked.append(badge_id)
        return Held(badge) if len(asked) < 3 else None

    free, _ = draw(Order("A"), taken_twice)
    assert len(set(asked)) == 3 and free.id == asked[-1]

    def someones(badge_id: str) -> Any:
        return Held(badge)

    with pytest.raises(RegistryError, match="all are issued"):
        draw(Order("A", lens="50lpi", code="pitch"), someones)

    def revoked(badge_id: str) -> Any:
        return Held(badge, revoked_at="2026-02-01")

    with pytest.raises(RegistryError, match="revoked"):
        plan_badge(replace(PLAIN, payload=bytes(8)), revoked)
