"""/openapi.json is true: schemathesis makes requests of it, right ones and wrong ones, and holds the answers to it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from kit.webbing import OpenStudio, Visit, film_form, studio, tiny_film
from moireid.badge import Badge

#: Requests of each route: it is the variety of the phases that finds things, and films take time.
EXAMPLES = 12


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio, ada: Badge) -> Visit:
    return open_studio(ada)


@pytest.mark.parametrize("mode", ["positive", "negative"])
@pytest.mark.slow
def test_schemathesis_finds_nothing(mode: str, tmp_path: Path, ada: Badge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a status, a body or a kind of content that is not declared; a wrong request that is taken; a 500."""
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    # Schemathesis starts and stops the application by itself.
    with studio(tmp_path, ada, work=False) as visit:
        ask_everything(visit, mode)


def ask_everything(visit: Visit, mode: str) -> None:
    """Have every operation asked, with right requests or with wrong ones."""
    # Here, as it takes more than a second to load, and each worker of the tests loads this file.
    import schemathesis

    operations = [
        found.ok() for found in schemathesis.openapi.from_asgi("/openapi.json", visit.app).get_all_operations()
    ]
    assert len(operations) > 8
    for operation in operations:
        # Where nothing but the token is sent, nothing else can be wrong.
        if mode == "negative" and not (operation.body or operation.path_parameters or operation.query):
            continue
        ask(operation, mode, {"Authorization": f"Bearer {visit.tokens['admin']}"})


def ask(operation, mode: str, bearer: dict[str, str]) -> None:
    """Ask one operation, and hold every answer to what is declared."""
    from schemathesis import GenerationMode
    from schemathesis.core.parameters import ParameterLocation
    from schemathesis.specs.openapi.checks import positive_data_acceptance

    # Bytes may be as declared and no film, a text no badge: no schema can say what is one.
    upload = [positive_data_acceptance] if operation.body else []

    @given(case=operation.as_strategy(generation_mode=GenerationMode(mode)))
    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def check(case) -> None:
        # The only header is the token.  It is put back, so a request whose fault is that it lacks one has none.
        header = case.meta.components.get(ParameterLocation.HEADER)
        assume(header is None or not header.mode.is_negative)
        case.call_and_validate(headers=bearer, excluded_checks=upload)

    check()


def test_answers_are_as_declared(visit: Visit, tmp_path: Path, films: Path) -> None:
    """Catches: a report or a job that breaks its schema, which films made up by schemathesis never reach."""
    import jsonschema
    from jsonschema.validators import Draft202012Validator

    document = visit.ask("GET", "/openapi.json", None).json()
    tiny = tiny_film(films / "genuine_1.0m.mp4", tmp_path / "tiny.mp4")
    cases = (("verify", {"claim": "Ada Lovelace"}, "Report"), ("identify", {}, None), ("jobs", {}, "JobStatus"))
    for route, fields, name in cases:
        path = f"/api/{route}"
        form = film_form(tiny, films / "badge.json" if route == "jobs" else None, **fields)
        answer = visit.ask("POST", path, "verifier", **form)
        declared = document["paths"][path]["post"]["responses"][str(answer.status_code)]["content"]["application/json"]
        assert name is None or declared["schema"] == {"$ref": f"#/components/schemas/{name}"}
        Draft202012Validator({**declared["schema"], "components": document["components"]}).validate(answer.json())
    with pytest.raises(jsonschema.ValidationError):
        broken = answer.json() | {"state": "nonsense"}
        Draft202012Validator({**declared["schema"], "components": document["components"]}).validate(broken)


def test_every_route_of_the_api_is_described(visit: Visit) -> None:
    """Catches: a route that /openapi.json does not tell of, and so nobody tests."""
    described = set(visit.ask("GET", "/openapi.json", None).json()["paths"])
    routes = {route.path for route in visit.app.routes if route.path.startswith("/api/")}
    assert described == routes
