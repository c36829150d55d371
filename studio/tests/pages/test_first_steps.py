"""What a visitor sees first: doors, empty pages, and words for who does not know the registry's log.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from kit.webbing import OpenStudio, Visit, studio
from moireid.badge import Badge
from moireid.registry.seen import recall

DOOR = re.compile(r'<a class="card door" href="([^"]+)">')


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada, work=False)


@pytest.fixture(scope="module")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Visit]:
    """A studio in whose registry no one is."""
    folder = tmp_path_factory.mktemp("empty")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOIREID_KEYS", str(folder / "keys"))
        with studio(folder, work=False) as opened:
            yield opened


@pytest.mark.parametrize(
    ("role", "doors"),
    [
        ("admin", ["/issue", "/enroll", "/verify", "/call"]),
        ("issuer", ["/issue", "/enroll"]),
        ("verifier", ["/verify", "/call"]),
        (None, []),
    ],
)
def test_the_first_page_has_the_doors_that_open_and_names_all_other_pages(
    visit: Visit, role: str | None, doors: list[str]
) -> None:
    """Catches: ten pages of one rank, of which a newcomer must read all; a door that is shut; a page without a way."""
    page = visit.ask("GET", "/", role).text
    assert DOOR.findall(page) == doors
    assert all(visit.ask("GET", door, role).status_code == 200 for door in doors)
    main = page[page.index("<main") :]
    places = re.findall(r'<a href="(/[^"]*)"', page[page.index("<nav") : page.index("</nav")])
    assert all(f'href="{place}"' in main for place in places if place != "/login")


def test_the_audit_offers_the_entry_that_the_studio_remembers(visit: Visit) -> None:
    """Catches: a field for a term that no visitor knows, which is empty although the studio has what it asks for."""
    head = str(recall().heads[visit.studio.registry.fingerprint])
    page = visit.ask("GET", "/registry/audit").text
    assert f'id="head" name="head" value="{head}"' in page and "noted earlier" not in page
    assert f"remembers entry <strong>{head.partition(':')[0]}</strong> as the last one" in page
    sound = visit.ask("POST", "/registry/audit", data={"head": head}).text
    assert "The registry is sound" in sound and f"<code>{head}</code>" in sound
    # One that was written down elsewhere counts, whatever the studio remembers.
    other = f"{head.partition(':')[0]}:{'0' * 64}"
    found = html.unescape(visit.ask("POST", "/registry/audit", data={"head": other}).text)
    assert "The registry is not sound" in found and f'value="{other}"' in found and head in found


def test_the_audit_of_a_studio_that_remembers_nothing(
    visit: Visit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: "None" in the field of a studio that may not write what it has seen."""
    (tmp_path / "file").touch()
    monkeypatch.setenv("MOIREID_SEEN", str(tmp_path / "file" / "seen.sqlite3"))
    page = visit.ask("GET", "/registry/audit").text
    assert 'id="head" name="head" value=""' in page and "remembers none yet" in page
