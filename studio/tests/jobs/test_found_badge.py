"""What an identification says of the badge that it found.  Each test names the wrong implementation it catches."""

from __future__ import annotations

from pathlib import Path

import pytest

from kit.registries import badge_of
from kit.webbing import badge_film, film_form, studio


@pytest.fixture(autouse=True)
def keys(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))


@pytest.mark.slow
def test_a_found_badge_says_who_else_could_have_it(tmp_path: Path) -> None:
    """Catches: an identification that says less of a badge than a verification does; notes by the decoder's word."""
    ada = badge_of("Ada Lovelace", None)
    with studio(tmp_path, ada) as visit:
        film = badge_film(ada, tmp_path / "f.mp4")
        answer = visit.ask("POST", "/api/identify", "verifier", **film_form(film))
        result = answer.json()
        assert result["found_id"] == ada.id, result
        codes = [reason["code"] for reason in result["reasons"]]
        assert codes[-1] == "copyable" and codes.count("copyable") == 1
