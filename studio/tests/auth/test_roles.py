"""Who may do what in the studio.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from fastapi.routing import APIRoute, APIWebSocketRoute

from kit.webbing import ORIGIN, OpenStudio, Visit, studio
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.scheduler import is_loopback
from moireid_studio.auth.guard import COOKIE, rules_of
from moireid_studio.auth.tokens import Tokens

#: What anybody may open; every other route asks for a role.
OPEN = {
    *("/", "/help", "/login", "/logout", "/healthz", "/readyz"),
    *("/check", "/check/look", "/check/socket"),
    # By the token of a job at work.
    *("/work/film", "/work/message"),
}
#: The roles of each part of the studio, by the beginning of its path; the longest beginning counts.
ROLES = {
    "/issue": {"issuer"},
    "/enroll": {"issuer"},
    "/api/badges": {"issuer"},
    "/registry": {"issuer", "verifier"},
    "/registry/audit": {"issuer"},
    "/registry/{badge_id}/revoke": {"issuer"},
    "/api/registry": {"issuer", "verifier"},
    "/api/registry/audit": {"issuer"},
    "/api/registry/{badge_id}/revoke": {"issuer"},
    "/api/verify": {"verifier"},
    "/api/identify": {"verifier"},
    "/api/jobs": {"verifier"},
    "/verify": {"verifier"},
    "/live": {"verifier"},
    "/live/enroll": {"issuer"},
    "/metrics": {"monitor"},
    "/call": {"verifier"},
    "/links": {"verifier"},
}


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada, work=False)


def routes(visit: Visit) -> list[APIRoute | APIWebSocketRoute]:
    """Every route of the application but that of /openapi.json, which says nothing of any person."""
    found = [route for route in visit.app.routes if getattr(route, "path", "") != "/openapi.json"]
    assert all(isinstance(route, APIRoute | APIWebSocketRoute) for route in found), found
    return found


def expected(path: str) -> set[str]:
    """Who may use a path, admins apart."""
    begins = [part for part in ROLES if path == part or path.startswith(part + "/")]
    assert begins, f"{path} has no rule in this test; say there who may use it"
    return ROLES[max(begins, key=len)]


def is_open(path: str) -> bool:
    return path in OPEN or path.startswith("/static/")


def test_every_route_names_its_rule(visit: Visit) -> None:
    """Catches: a new route without a rule of who may use it."""
    assert len(routes(visit)) > 20
    for route in routes(visit):
        rules = [rule for rule in rules_of(route) if rule.roles]
        if is_open(route.path):
            assert rules_of(route) and not rules, route.path
        else:
            assert [set(rule.roles) for rule in rules] == [expected(route.path)], route.path


@pytest.mark.claim("A token can do its role's work alone")
@pytest.mark.parametrize("role", [None, "issuer", "verifier", "monitor", "admin"])
def test_a_role_cannot_do_anothers_work(visit: Visit, role: str | None) -> None:
    """Catches: a rule that is named and not kept; a route that answers before it asks who it is."""
    for route in routes(visit):
        if not isinstance(route, APIRoute):
            continue
        path = re.sub(r"\{[^}]*\}", "0" * 32, route.path)
        for method in route.methods - {"HEAD"}:
            status = visit.ask(method, path, role).status_code
            if is_open(route.path) or role == "admin" or role in expected(route.path):
                assert status not in (401, 403) or path == "/login", (method, path, role)
            else:
                assert status == (403 if role else 401), (method, path, role)


def test_a_token_is_asked_for_and_its_revocation_counts_at_once(visit: Visit) -> None:
    """Catches: tokens compared loosely, kept after they were revoked, or taken from the URL."""
    secret, token = visit.studio.tokens.create("verifier", "newsroom")
    bearer = {"headers": {"Authorization": f"Bearer {secret}"}}
    assert visit.ask("GET", "/api/registry", None, **bearer).status_code == 200
    assert visit.ask("GET", f"/api/registry?token={secret}", None).status_code == 401
    for wrong in (secret[:-1], secret.upper(), secret + "x", "", token.id, "ü"):
        wrong_bearer = {"headers": {"Authorization": f"Bearer {wrong}".encode()}}
        assert visit.ask("GET", "/api/registry", None, **wrong_bearer).status_code == 401
    visit.studio.tokens.revoke(token.id)
    assert visit.ask("GET", "/api/registry", None, headers={"Authorization": f"Bearer {secret}"}).status_code == 401


def test_only_hashes_are_kept(tmp_path: Path) -> None:
    """Catches: a token that can be read from the studio's folder, or from the list."""
    tokens = Tokens(tmp_path)
    secret, token = tokens.create("issuer", "the printer's desk")
    assert tokens.find(secret) == token
    assert [found.role for found in tokens.all()] == ["issuer"]
    tokens.close()
    assert all(secret.encode() not in path.read_bytes() for path in tmp_path.iterdir())
    with pytest.raises(SpecError, match="no token has the id 'beef'"):
        Tokens(tmp_path).revoke("beef")


def test_a_browser_signs_in_by_a_cookie_that_no_script_reads(visit: Visit) -> None:
    """Catches: a cookie that scripts read or that other sites can have sent; a way on to a place of the visitor's."""
    sign_in = visit.ask("POST", "/login", None, data={"token": visit.tokens["issuer"], "back": "https://evil.test/"})
    assert (sign_in.status_code, sign_in.headers["location"]) == (303, "/")
    cookie = sign_in.headers["set-cookie"]
    assert "HttpOnly" in cookie and "SameSite=strict" in cookie and "Path=/" in cookie
    value = cookie.partition(";")[0].partition("=")[2]
    page = visit.ask("GET", "/registry", None, headers={"Cookie": f"{COOKIE}={value}"})
    assert page.status_code == 200 and "Sign out" in page.text
    assert visit.ask("POST", "/login", None, data={"token": "moireid_none"}).status_code == 401


@pytest.mark.parametrize(
    ("headers", "passes"),
    [
        ({}, True),
        ({"Origin": ORIGIN, "Sec-Fetch-Site": "same-origin"}, True),
        ({"Origin": "https://evil.test"}, False),
        ({"Origin": "null"}, False),
        ({"Origin": "http://studio.test:81"}, False),
        ({"Sec-Fetch-Site": "cross-site"}, False),
        ({"Sec-Fetch-Site": "same-site"}, False),
    ],
)
def test_no_other_site_makes_a_browser_change_things(visit: Visit, headers: dict[str, str], passes: bool) -> None:
    """Catches: a form on another site that revokes with the visitor's cookie; a guard that stops programs as well."""
    status = visit.ask("POST", "/registry/0000/revoke", "issuer", headers=headers).status_code
    assert (status != 403) is passes


def test_without_tokens_only_this_machine_is_answered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a page elsewhere that has its own name lead to this server, and then is of the same origin."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    with studio(tmp_path, auth=False, work=False) as visit:
        for host, status in (("127.0.0.1:8000", 200), ("localhost", 200), ("[::1]:9", 200), ("evil.test", 403)):
            assert visit.ask("GET", "/registry", None, headers={"Host": host}).status_code == status, host
        assert visit.ask("GET", "/registry", None, headers={"Host": "127.0.0.1.evil.test"}).status_code == 403


def test_every_answer_bears_strict_headers(visit: Visit) -> None:
    """Catches: an error page, a file or an API answer that forgot them; a policy that lets inline script run."""
    for path in ("/", "/nothing", "/healthz", "/api/nothing", "/static/studio.css", "/registry", "/openapi.json"):
        headers = visit.ask("GET", path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy and "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"


def test_pages_ask_for_nothing_from_outside_and_run_no_inline_script() -> None:
    """Catches: a font, a script or a picture of another server; script or style that the policy would block."""
    import moireid_studio

    for path in Path(moireid_studio.__file__).parent.rglob("*.*"):
        if path.suffix in (".j2", ".css", ".js", ".svg"):
            text = path.read_text().replace('xmlns="http://www.w3.org/2000/svg"', "")
            # What three.js makes elements of; it is a name, and no server's address.
            text = text.replace('"http://www.w3.org/1999/xhtml"', "")
            assert not re.search(r"https?://|src=\"//|@import", text), path
            assert path.suffix != ".j2" or not re.search(
                r"<style|\sstyle=|\son\w+=|<script(?! src=)|\|\s*safe", text
            ), path


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("::1", True),
        ("localhost", True),
        ("0.0.0.0", False),
        ("localhost.evil.test", False),
        ("", False),
    ],
)
def test_what_is_loopback(host: str, loopback: bool) -> None:
    """Catches: --no-auth on every address of the machine."""
    assert is_loopback(host) is loopback


def test_the_command_refuses_what_is_not_safe_or_not_there(tmp_path: Path) -> None:
    """Catches: a studio open to the network without tokens, a traceback where there is no registry."""
    url, data = f"sqlite:///{tmp_path}/none.sqlite3", str(tmp_path / "studio")
    for arguments, words in ((["--no-auth", "--host", "0.0.0.0"], "--host 127.0.0.1"), ([], "there is no registry")):
        done = CliRunner().invoke(moireid, ["serve", "--registry", url, "--data", data, *arguments])
        assert done.exit_code == 2 and words in done.output, done.output


def test_tokens_by_command(tmp_path: Path) -> None:
    """Catches: a token that is not printed alone, a list that shows it, a revocation that does nothing."""
    data = ["--data", str(tmp_path)]
    made = CliRunner().invoke(moireid, ["token", "create", "--role", "verifier", "--note", "desk", *data])
    assert made.exit_code == 0
    secret = made.stdout.strip()
    listed = CliRunner().invoke(moireid, ["token", "list", *data]).stdout
    assert secret not in listed and "verifier" in listed and "desk" in listed
    token_id = listed.split()[0]
    assert CliRunner().invoke(moireid, ["token", "revoke", token_id, *data]).exit_code == 0
    assert "revoked" in CliRunner().invoke(moireid, ["token", "list", *data]).stdout
    assert Tokens(tmp_path).find(secret) is None
    assert CliRunner().invoke(moireid, ["token", "create", "--role", "king", *data]).exit_code == 2
