"""What is said of a claim, whatever the film shows.  Each test states the wrong implementation that it would catch."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.provenance import FROM_FILE, Provenance
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.session.claim import Claim, claim_reasons, with_photographs

MATCH, OTHER = Identity("match", ()), Identity("mismatch", ())
REGISTRY = Provenance("registry")


def codes(claim: Claim, identity: Identity = MATCH) -> dict[str, str]:
    return {reason.code: reason.level for reason in claim_reasons(claim, identity)}


@pytest.fixture(scope="module")
def secret() -> Badge:
    return design_badge(Request("Ada Lovelace"), bytes.fromhex("0123456789abcdef"))


@pytest.fixture(scope="module")
def built(secret: Badge) -> AsBuilt:
    figures = {name: 0.0 for name in AsBuilt.__dataclass_fields__ if name not in ("badge_id", "captures")}
    return AsBuilt(badge_id=secret.id, captures=1, **figures)  # type: ignore[arg-type]


def test_each_finding_has_its_cause(secret: Badge, ada: Badge, built: AsBuilt) -> None:
    """Catches: a finding without its cause, one that changes a verdict unasked, a board taken for a person's badge."""
    assert codes(Claim(secret, secret.id, as_built=built, provenance=REGISTRY)) == {}
    assert codes(Claim(secret, secret.id, provenance=REGISTRY)) == {"copyable": "note"}
    assert codes(Claim(secret, secret.id, provenance=REGISTRY), OTHER) == {}
    assert codes(Claim(secret, secret.id, as_built=built, provenance=FROM_FILE)) == {"claim_source": "note"}
    assert codes(Claim(ada, ada.id, as_built=built)) == {"name_derived": "note"}
    alike = replace(REGISTRY, alike=("\u0410da (00)",))
    assert codes(Claim(secret, secret.id, as_built=built, provenance=alike)) == {"look_alike": "note"}
    chosen = Claim(secret, secret.id, as_built=built, provenance=replace(REGISTRY, line="Reporter", others=6))
    (found,) = claim_reasons(chosen, MATCH)
    assert (found.code, found.level) == ("chosen_line", "note") and "'Reporter'; 6 other badges bear" in found.text
    edited = replace(REGISTRY, file_name="Grace Hopper")
    assert codes(Claim(secret, secret.id, as_built=built, provenance=edited), OTHER) == {"name": "fail"}
    assert codes(Claim(ada, provenance=FROM_FILE)) == {}


def test_the_original_is_required_where_it_is_known(secret: Badge, built: AsBuilt) -> None:
    """Catches: a default that asks every badge for a film of it, and a wish that is overruled."""
    assert Claim(secret, secret.id, as_built=built).original_required
    assert not Claim(secret, secret.id).original_required
    assert not Claim(secret, secret.id, as_built=built, require_original=False).original_required
    assert Claim(secret, secret.id, require_original=True).original_required


MOTION = Reason("motion", "pass", 1.0, 0.25, "rad", "It moved.")
COUNTED = Reason("photographs", "note", 14.0, None, "photographs", "A forger would need at least 14 of the badge.")


@pytest.mark.parametrize(("least", "level"), [(0, "note"), (1, "pass"), (14, "pass"), (15, "undecided")])
def test_photographs_decide_where_they_are_asked_for(least: int, level: str) -> None:
    """Catches: a count that leaves films open unasked, a limit off by one, other findings lost or moved."""
    first, found = with_photographs((MOTION, COUNTED), least)
    assert first == MOTION and (found.level, found.measured) == (level, 14.0)
    assert worst([first, found]) == ("inconclusive" if level == "undecided" else "accept")
    if not least:
        assert found == COUNTED
        return
    assert found.limit == least and found.text.startswith(COUNTED.text) and f"Asked for: {least}." in found.text
    # What to do is told where something is to be done.
    assert ("Film longer ways" in found.text) == (level == "undecided")


def test_a_film_that_tells_no_count_is_open_where_one_is_asked_for() -> None:
    """Catches: a film too short to count in that is accepted, though so many photographs were asked for."""
    assert with_photographs((MOTION,), 0) == (MOTION,)
    first, found = with_photographs((MOTION,), 20)
    assert first == MOTION and (found.code, found.level, found.measured, found.limit) == (
        "photographs",
        "undecided",
        None,
        20.0,
    )
    assert "20 are asked for" in found.text
