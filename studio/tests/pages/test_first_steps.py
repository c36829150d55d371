"""What a visitor sees first: doors, empty pages, and words for who does not know the registry's log.

Each test names the wrong implementation it catches.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from kit.webbing import OpenStudio, Visit, studio
from moireid.badge import Badge

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
