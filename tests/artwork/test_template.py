"""Template files: those that come with the program, and what is refused in one of somebody's own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from moireid.artwork.template import BadgeTemplate, template_named, template_of
from moireid.errors import SpecError

OWN = """
colour = "teal"
[landscape]
head = 0.4
[[landscape.place]]
what = ["logo", "words"]
area = "upper"
[[landscape.place]]
what = "qr"
area = "foot"
"""


def test_toml_and_json_say_the_same(tmp_path: Path) -> None:
    """Catches: a reader of one form that leaves out keys of the other."""
    (tmp_path / "own.toml").write_text(OWN)
    document = {
        "colour": "teal",
        "landscape": {
            "head": 0.4,
            "place": [
                {"what": ["logo", "words"], "area": "upper"},
                {"what": "qr", "area": "foot"},
            ],
        },
    }
    (tmp_path / "own.json").write_text(json.dumps(document))
    one, other = (template_named(str(tmp_path / f"own.{kind}")) for kind in ("toml", "json"))
    assert one.sides == other.sides and one.colour == pytest.approx((0, 128 / 255, 128 / 255))
    assert one.sides["landscape"].places[1].area == "foot"
    with pytest.raises(SpecError, match=r"no \[portrait\], which this board needs"):
        one.side(54.0, 85.6)
    assert one.side(85.6, 54.0) is one.sides["landscape"]


def place(**keys: object) -> BadgeTemplate:
    return template_of({"portrait": {"place": [{"what": "name", "area": "head"} | keys]}}, "own")
