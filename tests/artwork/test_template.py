"""Template files: those that come with the program, and what is refused in one of somebody's own."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from moireid.artwork.template import TEMPLATES, TYPEFACES, BadgeTemplate, template_named, template_of
from moireid.cli.printing import print_options
from moireid.errors import SpecError
from moireid.fabrication.text import fonts

OWN = """
colour = "teal"
[landscape]
head = 0.4
[[landscape.place]]
what = ["logo", "words"]
area = "upper"
[[landscape.place]]
what = "qr"
at = [40, 5, 50, 15]
unit = "mm"
"""


def test_every_shipped_template_serves_landscape_and_portrait_boards() -> None:
    """Catches: a template that names an unknown piece or area, and one that the command does not offer."""
    assert print_options.TEMPLATES == TEMPLATES and len(TEMPLATES) == 10
    assert print_options.TYPEFACES == TYPEFACES == fonts.TYPEFACES
    for name in TEMPLATES:
        assert set(template_named(name).sides) == {"landscape", "portrait"}


def test_toml_and_json_say_the_same(tmp_path: Path) -> None:
    """Catches: a reader of one form that leaves out keys of the other."""
    (tmp_path / "own.toml").write_text(OWN)
    document = {
        "colour": "teal",
        "landscape": {
            "head": 0.4,
            "place": [
                {"what": ["logo", "words"], "area": "upper"},
                {"what": "qr", "at": [40, 5, 50, 15], "unit": "mm"},
            ],
        },
    }
    (tmp_path / "own.json").write_text(json.dumps(document))
    one, other = (template_named(str(tmp_path / f"own.{kind}")) for kind in ("toml", "json"))
    assert one.sides == other.sides and one.colour == pytest.approx((0, 128 / 255, 128 / 255))
    assert one.sides["landscape"].places[1].at == (40, 5, 50, 15)
    with pytest.raises(SpecError, match=r"no \[portrait\], which this board needs"):
        one.side(54.0, 85.6)
    assert one.side(85.6, 54.0) is one.sides["landscape"]


def place(**keys: object) -> BadgeTemplate:
    return template_of({"portrait": {"place": [{"what": "name", "area": "head"} | keys]}}, "own")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"what": "nmae"}, r'own: portrait.place.1.what must be one of .*name, .* got "nmae"; correct that key'),
        (
            {"area": "middle"},
            r'place.1.area must be one of base, crown, foot, head, lower, upper or null, got "middle"',
        ),
        ({"at": [0, 0, 1, 1]}, "must say area or at"),
        ({"area": "head", "colour": "red"}, 'place.1 has the unknown key "colour"; allowed are align, area'),
        ({"points": 900}, "place.1.points must be a number from 4 to 72, got 900"),
        ({"points": True}, "points must be a number"),
        ({"bleed": 1}, "bleed must be true or false"),
        ({"ground": "gold"}, 'ground must be one of accent, none, paper, tint, got "gold"'),
        ({"align": ["left"]}, "align must be one of center, left, right, got"),
    ],
)
def test_a_fault_is_named_with_its_place_and_what_is_allowed(keys: dict[str, object], message: str) -> None:
    """Catches: a slip that is skipped in silence, or ends in a traceback."""
    with pytest.raises(SpecError, match=message):
        place(**keys)


def test_rectangles_run_from_left_to_right_and_lie_in_their_unit() -> None:
    """Catches: exchanged corners, and millimetres taken for shares."""

    def at(*numbers: float, unit: str = "share") -> BadgeTemplate:
        entry = {"what": "name", "at": list(numbers), "unit": unit}
        return template_of({"portrait": {"place": [entry]}}, "own")

    with pytest.raises(SpecError, match="from left to right"):
        at(0.5, 0.1, 0.4, 0.2)
    with pytest.raises(SpecError, match="numbers from 0 to 1, got 50"):
        at(40, 5, 50, 15)
    assert at(40, 5, 50, 15, unit="mm").sides["portrait"].places[0].unit == "mm"


def test_what_is_no_template_is_refused(tmp_path: Path) -> None:
    """Catches: a file of any size or kind that is read to its end."""
    with pytest.raises(SpecError, match=r"'plane' is not known; choose one of plain, .* or give a .toml or .json file"):
        template_named("plane")
    with pytest.raises(SpecError, match="cannot be read"):
        template_named(str(tmp_path / "none.toml"))
    for name, text in (("a.json", "[" * 5000), ("b.toml", "= 3"), ("c.json", "\ud800")):
        (tmp_path / name).write_bytes(text.encode("utf-8", "surrogatepass"))
        with pytest.raises(SpecError, match=r"is not JSON|is not read as"):
            template_named(str(tmp_path / name))
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(SpecError, match="not a regular file"):
        template_named(str(tmp_path / "pipe.toml"))
    (tmp_path / "large.toml").write_text("#" * 200_000)
    with pytest.raises(SpecError, match="larger than 100 kB"):
        template_named(str(tmp_path / "large.toml"))
    with pytest.raises(SpecError, match="neither"):
        template_of({"words": "nothing"}, "own")
