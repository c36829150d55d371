"""What was promised to those outside.  Each test names what it catches."""

from __future__ import annotations

import json
from typing import Any

import click
import pytest

from kit.places import ROOT, TESTS
from moireid.cli.main import moireid

SCHEMA = ROOT / "src" / "moireid" / "schema"
PROMISED = json.loads((TESTS / "data" / "promised.json").read_text(encoding="utf-8"))


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


@pytest.mark.claim("No promised option is gone")
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
