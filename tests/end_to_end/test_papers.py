"""The project's papers for those outside: citation, security, promises.  Each test names what it catches."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import click
import pytest
import yaml
from jsonschema import Draft7Validator

from kit.places import ROOT, TESTS
from moireid.cli.main import moireid
from moireid.errors import MoireIdError

SCHEMA = ROOT / "src" / "moireid" / "schema"
PROMISED = json.loads((TESTS / "data" / "promised.json").read_text(encoding="utf-8"))


def citation() -> dict[str, Any]:
    # BaseLoader leaves each word a text, as the schema wants the version to be.
    return dict(yaml.load((ROOT / "CITATION.cff").read_text(encoding="utf-8"), Loader=yaml.BaseLoader))


def faults(document: dict[str, Any]) -> list[str]:
    """What the schema of the Citation File Format says against it; years are numbers there."""
    for one in document.get("references", []):
        one["year"] = int(one["year"])
    schema = json.loads((TESTS / "data" / "citation" / "schema.json").read_text(encoding="utf-8"))
    return [f"{list(fault.path)}: {fault.message}" for fault in Draft7Validator(schema).iter_errors(document)]


def test_the_citation_is_one_and_of_this_version() -> None:
    """Catches: a CITATION.cff that no reader takes, and the version or licence of last year."""
    assert faults(citation()) == []
    assert faults(citation() | {"authors": "nobody"}) != []
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (citation()["version"], citation()["license"]) == (project["version"], project["license"])


def named(group: click.Group = moireid, path: str = "") -> dict[str, list[str]]:
    """Each command with the names of its options, and of its arguments in capitals."""
    found: dict[str, list[str]] = {}
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        words = f"{path} {name}".strip()
        if isinstance(command, click.Group):
            found |= named(command, words)
        else:
            parts = [[one.name or ""] if isinstance(one, click.Argument) else one.opts for one in command.params]
            found[words] = sorted(word for part in parts for word in part)
    return found


def keys_of(schema: dict[str, Any], path: str = "") -> set[str]:
    """Every key that a schema names, by its path."""
    found = set()
    for name, inner in schema.get("properties", {}).items():
        found |= {f"{path}{name}"} | keys_of(inner, f"{path}{name}.")
    for inner in (schema.get("items"), *schema.get("anyOf", []), *schema.get("oneOf", [])):
        found |= keys_of(inner, path) if isinstance(inner, dict) else set()
    return found


def test_nothing_that_was_promised_is_gone() -> None:
    """Catches: an option that vanishes or is renamed without the notice that docs/reference/versions.md promises."""
    here = named()
    gone = [
        f"{name} {word}"
        for name, words in PROMISED["commands"].items()
        for word in words
        if word not in here.get(name, [])
    ]
    assert gone == [], "announce it first: docs/reference/versions.md; then take it out of tests/data/promised.json"


@pytest.mark.parametrize("name", ["report", "badge", "attestation"])
def test_no_key_that_was_promised_is_gone(name: str) -> None:
    """Catches: a key that is renamed within a format, so that programs which read it fail."""
    schema = json.loads((SCHEMA / f"{name}.schema.json").read_text(encoding="utf-8"))
    assert set(PROMISED["keys"][name]) <= keys_of(schema), "a key goes only with a new format"


def test_the_list_of_promises_is_one() -> None:
    """Catches: a list so short that the two tests above hold for nothing."""
    assert "--claim" in PROMISED["commands"]["verify"] and "--out" in PROMISED["commands"]["print"]
    assert {"verdict", "reasons", "identity.decoded_id"} <= set(PROMISED["keys"]["report"])
    assert {"id", "gratings", "lens.pitch_mm"} <= set(PROMISED["keys"]["badge"])
    assert set(PROMISED["errors"]) <= {one.__name__ for one in MoireIdError.__subclasses__()}
