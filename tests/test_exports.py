"""The names that other code may rely on, pinned: dropping or adding one is a decision, not an accident."""

from __future__ import annotations

import importlib

import pytest

EXPORTED = {
    "moireid.errors": [
        "CodeError",
        "DesignError",
        "FabricationError",
        "MediaError",
        "MissingExtraError",
        "MoireIdError",
        "RegistryError",
        "SpecError",
    ],
    "moireid.idcodes": [
        "WRONG_PERSON",
        "CellReading",
        "CodeFamily",
        "Decoded",
        "PartialWord",
        "PitchFamily",
        "SpacingFamily",
        "family_named",
        "spells_its_id",
    ],
    "moireid.designer": [
        "Request",
        "design_badge",
        "explain",
        "payload_for_name",
        "payload_from_hex",
        "payload_from_key",
    ],
    "moireid.verifier": ["Claim", "Film", "Frame", "Report", "Running", "Verifier", "verify"],
    "moireid.registry": [
        "Audit",
        "Batch",
        "Claimed",
        "Finding",
        "Import",
        "People",
        "Record",
        "Registry",
        "claimed",
        "default_url",
        "import_registry",
        "open_registry",
    ],
}


@pytest.mark.parametrize("module", EXPORTED)
def test_exported_names_are_pinned_and_exist(module: str) -> None:
    """Catches: a renamed, lost or unintended public name."""
    room = importlib.import_module(module)
    assert room.__all__ == EXPORTED[module]
    assert [name for name in room.__all__ if not hasattr(room, name)] == []


def test_error_tree_has_one_base_and_one_level() -> None:
    """Catches: an error that `except MoireIdError` misses, or one that is caught as another kind."""
    errors = importlib.import_module("moireid.errors")
    kinds = [getattr(errors, name) for name in EXPORTED["moireid.errors"] if name != "MoireIdError"]
    assert {kind.__mro__[1] for kind in kinds} == {errors.MoireIdError}
    assert errors.MoireIdError.__mro__[1] is Exception


def test_an_error_keeps_its_figures_and_its_sentence() -> None:
    """Catches: `details` merged into the message, shared between errors, or lost."""
    errors = importlib.import_module("moireid.errors")
    first = errors.DesignError("too far", reach_m=1.5)
    second = errors.SpecError("no name")
    assert (str(first), first.details) == ("too far", {"reach_m": 1.5})
    assert (str(second), second.details) == ("no name", {})
