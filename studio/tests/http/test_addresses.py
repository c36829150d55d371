"""The address in links for other people.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import re

import pytest

from kit.webbing import ORIGIN, OpenStudio, Visit, studio
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid_studio.http.addresses import checked_address

PUBLIC = "https://studio.example.org/"
FALSE = {"host": "evil.example"}
ADDRESS = re.compile(r'value="([^"]*)check#[\w-]{43}"')
WISH = {"claim": "Ada Lovelace", "asks": "Sam of accounts"}


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada, work=False)


@pytest.fixture(scope="module")
def public(ada: Badge, tmp_path_factory: pytest.TempPathFactory) -> Visit:
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("public")
        patch.setenv("MOIREID_KEYS", str(folder / "keys"))
        with studio(folder, ada, work=False, public_url=PUBLIC) as opened:
            yield opened


def link(visit: Visit, **headers: str) -> str:
    """What the address of a new link begins with."""
    answer = visit.ask("POST", "/links", "verifier", data=WISH, headers=headers)
    assert answer.status_code == 200, answer.text
    (found,) = ADDRESS.findall(answer.text)
    return str(found)


def test_a_false_host_is_shown_to_no_other_visitor(visit: Visit) -> None:
    """Catches: an address that is kept with the link, or in the process: who asks next would send others to it."""
    assert link(visit, **FALSE) == "http://evil.example/"
    for role, path in (("verifier", "/links"), ("admin", "/links"), ("admin", "/help"), ("verifier", "/help")):
        assert "evil" not in visit.ask("GET", path, role).text
    (newest,) = set(re.findall(r"/links/([0-9a-f]{16})", visit.ask("GET", "/links", "verifier").text))
    assert "evil" not in visit.ask("GET", f"/links/{newest}", "verifier").text
    assert link(visit) == f"{ORIGIN}/"
    # The false answer may be kept by no cache between the studio and others.
    assert visit.ask("GET", "/help", headers=FALSE).headers["Cache-Control"] == "no-store"


def test_with_a_public_address_the_header_is_not_used(public: Visit) -> None:
    """Catches: a link to whatever Host says, where the operator has said what it must be."""
    for headers in ({}, FALSE, {"host": "["}, {"x-forwarded-host": "evil.example"}, {"host": "127.0.0.1:8000"}):
        assert link(public, **headers) == PUBLIC
        assert f"{PUBLIC}api/verify" in public.ask("GET", "/help", headers=headers).text


@pytest.mark.parametrize(
    "given",
    [
        *("", "studio.example.org", "ftp://studio.example.org", "https://", "https://a@b/", "https://a/path"),
        *("https://a/?q", "https://a/#b", "https://[", "https://a:99999", "http://studio.example.org", "javascript:a"),
    ],
)
def test_what_is_no_address_is_refused(given: str) -> None:
    """Catches: links that no one can open, or that open a page without a camera."""
    with pytest.raises(SpecError, match=r"studio.example.org|over https"):
        checked_address(given)
