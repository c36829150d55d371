"""What is said of a claim, whatever the film shows.  Each test states the wrong implementation that it would catch."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import SpecError
from moireid.provenance import FROM_FILE, Provenance
from moireid.question import Question
from moireid.verifier.identity.decode import Identity
from moireid.verifier.session.claim import claim_reasons, least_strength

MATCH, OTHER = Identity("match", ()), Identity("mismatch", ())
REGISTRY = Provenance("registry")


def codes(claim: Question, identity: Identity = MATCH) -> dict[str, str]:
    return {reason.code: reason.level for reason in claim_reasons(claim, identity)}


@pytest.fixture(scope="module")
def secret() -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi"), bytes.fromhex("0123456789abcdef"))


@pytest.fixture(scope="module")
def built(secret: Badge) -> AsBuilt:
    figures = {name: 0.0 for name in AsBuilt.__dataclass_fields__ if name not in ("badge_id", "captures")}
    return AsBuilt(badge_id=secret.id, captures=1, **figures)  # type: ignore[arg-type]


def test_each_finding_has_its_cause(secret: Badge, ada: Badge, built: AsBuilt) -> None:
    """Catches: a finding without its cause, one that changes a verdict unasked, a board taken for a person's badge."""
    assert codes(Question(secret, secret.id, as_built=built, provenance=REGISTRY)) == {}
    assert codes(Question(secret, secret.id, provenance=REGISTRY)) == {"copyable": "note"}
    assert codes(Question(secret, secret.id, provenance=REGISTRY), OTHER) == {}
    assert codes(Question(secret, secret.id, as_built=built, provenance=FROM_FILE)) == {"claim_source": "note"}
    alike = replace(REGISTRY, alike=("\u0410da (00)",))
    assert codes(Question(secret, secret.id, as_built=built, provenance=alike)) == {"look_alike": "note"}
    edited = replace(REGISTRY, file_name="Grace Hopper")
    assert codes(Question(secret, secret.id, as_built=built, provenance=edited), OTHER) == {"name": "fail"}
    assert codes(Question(ada, provenance=FROM_FILE)) == {}


def test_the_original_is_required_where_it_is_known(secret: Badge, built: AsBuilt) -> None:
    """Catches: a default that asks every badge for a film of it, and a wish that is overruled."""
    assert Question(secret, secret.id, as_built=built).original_required
    assert not Question(secret, secret.id).original_required
    assert Question(secret, secret.id, as_built=built, level="record").original_required
    assert Question(secret, secret.id, as_built=built, level="enrolled").original_required


@pytest.mark.parametrize("strength", [0, 49, 501])
def test_a_strength_that_is_weaker_than_the_default_or_cannot_be_shown_is_refused(strength: int, secret: Badge) -> None:
    """Catches: an acceptance at any share; a division by 0; one that no film could ever reach."""
    assert least_strength(Question(secret, strength=500)) == 500 and least_strength(Question(secret)) == 50
    with pytest.raises(SpecError, match="strength is 50 to 500"):
        least_strength(Question(secret, strength=strength))
