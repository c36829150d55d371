"""The authority that is trusted, through the whole of a check.  Each test names the fault that it catches."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from moireid.api.asking import claim_context
from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.registry import open_registry


@pytest.mark.claim("--trust holds until the verdict is given")
def test_the_look_up_after_the_film_asks_the_trusted_registry(
    tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a registry that takes the trusted one's place while the film is judged, and names the badge's holder."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    # Nothing is remembered, so --trust alone says which authority is the right one.
    monkeypatch.setenv("MOIREID_SEEN", "/dev/null/seen.sqlite3")
    trusted = None
    for name in ("other", "people"):
        with open_registry(f"sqlite:///{tmp_path}/{name}.sqlite3", create=True) as registry:
            registry.enroll(ada)
            if name == "other":
                # Else the two files have one change counter, and SQLite goes on with the trusted one's pages.
                registry.revoke(ada.name, "lost")
            trusted = registry.fingerprint
    url = f"sqlite:///{tmp_path}/people.sqlite3"
    document = {"identity": {"decoded_id": ada.id, "verdict": "mismatch"}}
    with claim_context("Ada Lovelace", None, url, None, trusted, lambda standing: None) as (_, look_up):
        assert look_up(document).read is not None
        shutil.copy(tmp_path / "other.sqlite3", tmp_path / "people.sqlite3")
        with pytest.raises(RegistryError, match="authority"):
            look_up(document)
