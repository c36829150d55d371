"""The address in links for other people.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import re
import socket
from pathlib import Path

import pytest
from click.testing import CliRunner
from fastapi import FastAPI

from kit.webbing import ORIGIN, OpenStudio, Visit, studio
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid_studio.http.addresses import checked_address
from moireid_studio.settings import Settings

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


@pytest.mark.parametrize("host", ["[", "a@b", "a/b", "a\\b", "a#b", "a?b", "a<b>", ""])
def test_a_host_that_is_no_address_is_not_used(visit: Visit, host: str) -> None:
    """Catches: a traceback; a link such as http://studio.test@evil.example/."""
    assert link(visit, host=host).startswith("http://studio.test:")


def test_with_a_public_address_the_header_is_not_used(public: Visit) -> None:
    """Catches: a link to whatever Host says, where the operator has said what it must be."""
    for headers in ({}, FALSE, {"host": "["}, {"x-forwarded-host": "evil.example"}, {"host": "127.0.0.1:8000"}):
        assert link(public, **headers) == PUBLIC
        assert f"{PUBLIC}api/verify" in public.ask("GET", "/help", headers=headers).text


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("https://studio.example.org", PUBLIC),
        (" https://studio.example.org/ ", PUBLIC),
        ("https://studio.example.org:8443", "https://studio.example.org:8443/"),
        ("http://localhost:8000", "http://localhost:8000/"),
    ],
)
def test_an_address_is_taken(given: str, kept: str) -> None:
    """Catches: two slashes before check, or none."""
    assert checked_address(given) == kept


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


def test_the_command_takes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: an option that is not passed on; a public address of a studio that answers this machine alone."""
    begun: list[Settings] = []

    def serve(app: FastAPI, bound: socket.socket) -> None:
        begun.append(app.state.studio.settings)
        app.state.studio.close()
        bound.close()

    monkeypatch.setattr("moireid_studio.http.server.serve", serve)
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    registry = f"sqlite:///{tmp_path}/r.sqlite3"
    monkeypatch.setattr("moireid_studio.commands.serve_cmd._default_is_there", lambda: True)
    monkeypatch.setattr("moireid.registry.engine.default_url", lambda: registry)
    command = ["serve", "--port", "0", "--data", str(tmp_path / "data"), "--unsealed"]

    def run(*more: str) -> str:
        done = CliRunner().invoke(moireid, [*command, *more])
        return done.stderr if done.exit_code else ""

    assert run() == "" and begun.pop().public_url is None
    assert run("--public-url", "https://studio.example.org") == "" and begun.pop().public_url == PUBLIC
    assert "no address of a studio" in run("--public-url", "studio.example.org")
    assert "--no-auth answers this machine alone" in run("--no-auth", "--public-url", PUBLIC)
    monkeypatch.setenv("MOIREID_PUBLIC_URL", PUBLIC)
    assert run() == "" and begun.pop().public_url == PUBLIC
    assert run("--no-auth") == "" and begun.pop().public_url is None
