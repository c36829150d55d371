"""What a registry makes of an identification.  Each test names the wrong implementation it catches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from moireid.api.asking import with_holder
from moireid.api.places import url_of
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.registry import open_registry


def test_one_who_is_found_is_enrolled_and_counts(tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: someone found whom no one enrolled, or who was revoked; a measured badge said to be copyable."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "seen.sqlite3"))
    last = {"code": "enrolled", "level": "pass"}
    found: dict[str, Any] = {"finding": "found", "found_id": ada.id, "reasons": [last]}
    with open_registry(f"sqlite:///{tmp_path}/people.sqlite3", create=True) as registry:
        assert with_holder(found, registry)["finding"] == "nobody"
        registry.enroll(ada)
        named = with_holder(found, registry)
        assert (named["finding"], named["found_name"]) == ("found", ada.name)
        assert [reason["code"] for reason in named["reasons"]] == ["enrolled", "copyable"]
        assert with_holder(found | {"found_id": None}, registry)["found_name"] is None
        figures = AsBuilt(str(ada.id), -0.04, 2e-5, 3.0, 0.04, 0.03, 3e-4, 0.99, 0.01)
        registry.store_as_built(str(ada.id), figures.to_json())
        assert with_holder(found, registry)["reasons"] == [last]
        registry.revoke(ada.name, "lost")
        gone = with_holder(found, registry)
        assert (gone["finding"], gone["found_id"], gone["found_name"]) == ("nobody", None, None)
        assert [reason["level"] for reason in gone["reasons"]] == ["fail"]


@pytest.mark.parametrize("name", ["ab:d.sqlite3", "x@y:z@w.db", "plain.db"])
def test_a_path_is_no_url(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str):
    """Catches: a file whose name looks like the address of a database; a path without a name."""
    monkeypatch.chdir(tmp_path)
    for place in (Path(name), name):
        assert url_of(place) == str(tmp_path / name)
    assert url_of("sqlite:///a.db") == "sqlite:///a.db"
    with pytest.raises(SpecError, match="the path is empty"):
        url_of("  ")
