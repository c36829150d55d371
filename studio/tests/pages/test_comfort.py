"""What makes the studio easy: samples, its own page for each failure, words that people say.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import moireid_studio
from kit.webbing import OpenStudio, Visit
from moireid.badge import Badge, load_badge
from moireid_studio.pages import registry_pages as registry_pages


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada)


@pytest.mark.slow
def test_the_samples_are_what_they_are_called(visit: Visit) -> None:
    """Catches: a sample that is not shipped, or that teaches the wrong verdict; a badge of somebody's."""
    folder = Path(moireid_studio.__file__).parent / "samples"
    assert visit.studio.registry.by_id(load_badge(folder / "badge.json").id or "") is None
    for which, verdict in (("true", "accept"), ("forged", "reject")):
        answer = visit.ask("POST", "/verify/sample", data={"which": which})
        assert answer.status_code == 303
        assert visit.wait(answer.headers["location"].rpartition("/")[2])["result"]["verdict"] == verdict
    assert visit.ask("POST", "/verify/sample", data={"which": "../badge"}).status_code == 422


def test_every_failure_has_the_studios_own_page(visit: Visit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a bare line of text, a traceback, or an answer that passes none of the guard's rules."""
    monkeypatch.setattr(registry_pages, "SHOWN", "no number")
    too_much = {"people": "x" * (2 << 20)}
    for status, answer in (
        (404, visit.ask("GET", "/nowhere")),
        (405, visit.ask("POST", "/help")),
        (413, visit.ask("POST", "/login", data=too_much)),
        (500, visit.ask("GET", "/registry")),
    ):
        assert answer.status_code == status
        assert '<nav id="menu" aria-label="Studio" popover>' in answer.text and 'role="alert"' in answer.text, status
        assert "default-src 'none'" in answer.headers["content-security-policy"], status
        assert "Traceback" not in answer.text and "no number" not in answer.text
