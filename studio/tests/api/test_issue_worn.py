"""Badges to wear, from the form and the API.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from kit.webbing import OpenStudio, Visit
from moireid.badge import badge_from_json
from moireid.cli.main import moireid


@pytest.fixture(scope="module")
def visit(open_studio: OpenStudio) -> Visit:
    return open_studio()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fields", "arguments"),
    [
        (
            {"format": "a6", "orientation": "portrait", "markers": "frame"},
            ["--format", "a6", "--orientation", "portrait", "--markers", "frame"],
        ),
        (
            {"format": "webcam", "colour": "teal", "lines": "Guest"},
            ["--format", "webcam", "--colour", "teal", "--line", "Guest"],
        ),
        ({"axes": "hex"}, ["--axes", "hex"]),
        (
            {"format": "a5", "template": "court", "far_m": "1.5"},
            ["--format", "a5", "--template", "court", "--range", "0.6-1.5"],
        ),
    ],
)
def test_a_wish_gives_the_command_s_own_badge(
    visit: Visit, fields: dict[str, str], arguments: list[str], tmp_path: Path
) -> None:
    """Catches: a choice that does nothing, a sheet or a range that is not the command's, a frame without its room."""
    wish = {"name": "Ada", "payload": "7097c67b0fafc59b", "mount": "none"}
    body: dict[str, Any] = wish | fields
    body |= {"lines": fields["lines"].splitlines()} if "lines" in fields else {}
    body |= {"range_m": [0.6, float(body.pop("far_m"))]} if "far_m" in fields else {}
    answer = visit.ask("POST", "/api/badges/check", "issuer", json=body)
    out = tmp_path / "out"
    result = CliRunner().invoke(
        moireid, ["print", "Ada", "--payload", wish["payload"], "--out", str(out), "--mount", "none", *arguments]
    )
    assert result.exit_code == 0, result.stderr
    by_command = badge_from_json((out / "badge.json").read_text())
    assert answer.status_code == 200, answer.text
    assert badge_from_json(json.dumps(answer.json()["badge"])) == by_command
