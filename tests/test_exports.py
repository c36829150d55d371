"""The names that other code may rely on, pinned: dropping or adding one is a decision, not an accident."""

from __future__ import annotations

import importlib

import pytest

EXPORTED = {
    "moireid.errors": (
        "CodeError DesignError FabricationError MediaError MissingExtraError MoireIdError RegistryError SpecError"
    ),
    "moireid.idcodes": (
        "WRONG_PERSON CellReading CodeFamily DecodeResult PartialWord PitchFamily SpacingFamily family_named "
        "specimen_of spells_its_id"
    ),
    "moireid.designer": ("Order design_badge design_chart explain payload_from_hex random_payload"),
    "moireid.simulate": (
        "Build Camera DiscLight FilmReport Motion Need Poses Scene camera_named film light_named motion_named "
        "truth_path"
    ),
    "moireid.fabrication": "PrintResult mount_solids print_badge print_event write_badge_pdf",
    "moireid.calibration": "ChartView lens_from_band lens_from_views load_pictures view_chart",
    "moireid.attest": (
        "CertificateIdentity CheckResult SigningKey check held_against load_public_key load_signing_key signed_envelope"
    ),
    "moireid.verifier": (
        "Circumstances Film Frame Identification KnownCamera Question Report Running Verifier identify verify "
        "write_report"
    ),
    "moireid.registry": (
        "Audit BadgeHolder Batch Finding Import LookAlikeWarning People Record Registry claimed "
        "claimed_by_file default_url holder_of import_registry open_registry people_of"
    ),
    "moireid_studio.challenge": "StreamCheck",
}


@pytest.mark.parametrize("module", EXPORTED)
def test_exported_names_are_pinned_and_exist(module: str) -> None:
    """Catches: a renamed, lost or unintended public name."""
    room = importlib.import_module(module)
    assert room.__all__ == EXPORTED[module].split()
    assert [name for name in room.__all__ if not hasattr(room, name)] == []


def test_error_tree_has_one_base_and_one_level() -> None:
    """Catches: an error that `except MoireIdError` misses, or one that is caught as another kind."""
    errors = importlib.import_module("moireid.errors")
    kinds = [getattr(errors, name) for name in EXPORTED["moireid.errors"].split() if name != "MoireIdError"]
    assert {kind.__mro__[1] for kind in kinds} == {errors.MoireIdError}
    assert errors.MoireIdError.__mro__[1] is Exception
