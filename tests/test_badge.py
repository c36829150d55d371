"""badge.json: what goes in comes out, and what is wrong is refused by one sentence that names the place."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from typing import Any

import pytest

from moireid.badge import Badge, Cell, CodedFrame, Grating, Lens, Markers, badge_from_json
from moireid.designer import Order, design_badge
from moireid.errors import SpecError

Document = dict[str, Any]


def by_hand() -> Document:
    """A board described by hand, asymmetric in all it can be, with every key that the contract names."""
    return {
        "format": 1,
        "id": None,
        "name": "Tafel Übung",
        "page": {"width_mm": 150, "height_mm": 130.5},
        "lens": {"kind": "lenticular", "pitch_mm": 0.508, "thickness_mm": 1, "refractive_index": 1.56},
        "gratings": [
            {
                "rect_mm": [30, 40, 120, 90],
                "axis": "x",
                "pitch_mm": 0.52,
                "family": "uniform",
                "cells": [{"rect_mm": [30, 40, 120, 62], "pitch_mm": 0.52, "edge_mm": 30.1, "duty": 0.4}],
            },
            {
                "rect_mm": [30, 95, 120, 110],
                "axis": "y",
                "pitch_mm": 0.53,
                "family": "uniform",
                "cells": [{"rect_mm": [30, 95, 120, 110], "pitch_mm": 0.53, "edge_mm": -7, "duty": 0.6}],
            },
        ],
        "markers": {
            "dictionary": "DICT_5X5_100",
            "size_mm": 20,
            "ids": [7, 3, 99, 0],
            "centers_mm": [[15, 16], [135, 16], [134, 114], [15, 114]],
        },
    }


def issued(badge: Badge) -> Document:
    return json.loads(badge.to_json())


def refusal(text: str) -> str:
    """The message with which the text is refused; any other exception is a failure."""
    try:
        badge_from_json(text, source="b.json")
    except SpecError as error:
        message = str(error)
        assert "\n" not in message and len(message) < 600, message
        return message
    raise AssertionError(f"accepted: {text[:300]}")


# There and back.


def test_an_issued_badge_survives_its_json(ada: Badge) -> None:
    """Catches: figures rounded on the way, keys lost, a file without its final newline."""
    text = ada.to_json()
    assert badge_from_json(text) == ada
    assert badge_from_json(text).to_json() == text
    assert text.endswith("}\n")
    masked = replace(ada, lens=Lens("mask", 0.5, 1.0, 1.49, open_fraction=0.3), board_mm=None, range_m=None, print=None)
    assert badge_from_json(masked.to_json()) == masked


@pytest.mark.claim("badge.json has every key of the contract")
def test_every_key_of_the_contract_is_written(ada: Badge) -> None:
    """Catches: a renamed key; other programs read these."""
    document = issued(ada)
    assert {"format", "id", "name", "page", "lens", "gratings", "markers", "payload_bits", "print"} <= set(document)
    assert set(document["page"]) == {"width_mm", "height_mm"}
    assert {"kind", "pitch_mm", "thickness_mm", "refractive_index"} <= set(document["lens"])
    assert {"rect_mm", "axis", "pitch_mm", "family", "cells"} <= set(document["gratings"][0])
    assert {"rect_mm", "pitch_mm", "edge_mm", "duty"} <= set(document["gratings"][0]["cells"][0])
    assert {"dictionary", "size_mm", "ids", "centers_mm"} <= set(document["markers"])
    assert (document["format"], document["print"]["dpi"]) == (2, 1200)


def test_a_board_described_by_hand_is_read_figure_by_figure() -> None:
    """Catches: width and height, x and y, or the order of markers swapped; integers that stay integers."""
    badge = badge_from_json(json.dumps(by_hand()))
    assert (badge.id, badge.name, badge.page_mm) == (None, "Tafel Übung", (150.0, 130.5))
    assert badge.outline_mm == (0.0, 0.0, 150.0, 130.5)
    assert badge.gratings[1] == Grating(
        (30.0, 95.0, 120.0, 110.0), "y", 0.53, "uniform", (Cell((30.0, 95.0, 120.0, 110.0), 0.53, -7.0, 0.6),)
    )
    assert badge.markers == Markers(
        "DICT_5X5_100", 20.0, (7, 3, 99, 0), ((15.0, 16.0), (135.0, 16.0), (134.0, 114.0), (15.0, 114.0))
    )
    assert (badge.payload_bits, badge.print, badge.range_m) == (None, None, None)


def test_the_published_prototype_is_read(prototype: Badge) -> None:
    """Catches: a schema that refuses the contract's own example."""
    assert (prototype.id, prototype.page_mm, prototype.gratings[0].pitch_mm) == (None, (146.0, 146.0), 0.52)


def test_a_frame_survives_its_json_and_says_what_it_is() -> None:
    """Catches: notches lost or in another order; a frame that a reader of squares takes for squares."""
    badge = badge_from_json(json.dumps(by_hand() | {"markers": _frame()}))
    assert isinstance(badge.markers, CodedFrame) and badge_from_json(badge.to_json()) == badge
    assert json.loads(badge.to_json())["markers"] == _frame()
    with pytest.raises(SpecError, match="four squares"):
        _ = badge.squares


def test_whole_numbers_of_a_code_are_integers_however_they_are_written(ada: Badge) -> None:
    """Catches: `range(8.0)`, and a layout that differs by how a number was written."""
    document = issued(ada)
    code = document["gratings"][0]["code"]
    code.update({key: float(code[key]) for key in ("payload_bits", "levels", "phase_levels")})
    badge = badge_from_json(json.dumps(document | {"payload_bits": 64.0}))
    assert badge == ada
    read = badge.gratings[0].code
    assert read is not None
    assert {type(n) for n in (read.payload_bits, read.levels, read.phase_levels, badge.payload_bits)} == {int}


def test_a_badge_is_frozen_and_has_a_hash(ada: Badge) -> None:
    """Catches: a badge that is changed after issue, or a print record that makes it unhashable."""
    with pytest.raises(FrozenInstanceError):
        ada.name = "Eve"  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        ada.gratings[0].cells[0].pitch_mm = 0.5  # type: ignore[misc]
    assert hash(ada) == hash(badge_from_json(ada.to_json()))


# The lens.


def test_defaults_of_a_lens_are_those_of_the_contract() -> None:
    """Catches: a focus at g / n or R = g (n - 1), and a mask that is open by another share than a half."""
    assert Lens("lenticular", 0.508, 1.3, 1.5).radius_mm == pytest.approx(1.3 * 0.5 / 1.5)
    assert Lens("lenticular", 0.508, 1.3, 1.5, radius_mm=0.9).radius_mm == 0.9
    assert Lens("mask", 0.508, 1.3, 1.0).open_fraction == 0.5
    assert Lens("mask", 0.508, 1.3, 1.0).radius_mm is None


# Layouts.


def test_layout_key_tells_layouts_apart_and_people_not(ada: Badge) -> None:
    """Catches: a key that forgets the optics or the markers, or that depends on what a reader cannot know yet."""
    grating = ada.gratings[0]
    assert grating.code is not None
    same = [
        replace(ada, id="000000", name="Bob", print={"dpi": 600}, range_m=(1.0, 2.0)),
        design_badge(Order("Bob", lens="50lpi"), bytes(range(8))),
        replace(ada, gratings=(replace(grating, cells=tuple(replace(c, edge_mm=0.0) for c in grating.cells)),)),
    ]
    assert {badge.layout_key() for badge in same} == {ada.layout_key()}
    centers = ada.markers.centers_mm
    other = [
        replace(ada, lens=replace(ada.lens, thickness_mm=1.1)),
        replace(ada, lens=replace(ada.lens, pitch_mm=0.5)),
        replace(ada, markers=replace(ada.markers, ids=(0, 1, 3, 2))),
        replace(ada, markers=replace(ada.markers, centers_mm=((50.1, 86.5), *centers[1:]))),
        replace(ada, board_mm=None),
        replace(ada, page_mm=(210.0, 298.0)),
        replace(ada, gratings=(replace(grating, axis="y"),)),
        replace(ada, gratings=(replace(grating, code=replace(grating.code, levels=7)),)),
        replace(ada, gratings=(replace(grating, code=replace(grating.code, payload_bits=128)),)),
        replace(ada, gratings=(replace(grating, cells=grating.cells[:-1]),)),
        replace(ada, gratings=(replace(grating, cells=tuple(replace(c, duty=0.4) for c in grating.cells)),)),
    ]
    assert len({badge.layout_key() for badge in [ada, *other]}) == len(other) + 1


# What is refused, and how.


def _grating(document: Document) -> Document:
    return document["gratings"][0]


def _code(roles: list[str] | None = None, **figures: float) -> Document:
    """A code for the one cell of the first grating, sound but for what is given."""
    sound = {"payload_bits": 64, "levels": 8, "base_frequency_per_mm": -0.03, "frequency_step_per_mm": -0.004}
    return {"roles": roles or ["reference"]} | sound | figures


def _frame(**changed: object) -> Document:
    """A coded frame, sound but for what is given."""
    notches = [[20, 11, 30, 12], [50, 11, 60, 12], [80, 11, 90, 12], [138, 30, 139, 40], [60, 118, 70, 119]]
    return {"kind": "frame", "rect_mm": [10, 10, 140, 120], "line_mm": 2, "notches_mm": notches} | changed


WRONG: list[tuple[str, str, Callable[[Document], object]]] = [
    ("cell off its grating", "gratings.0.cells.0", lambda d: _grating(d)["cells"][0].update(rect_mm=[29, 40, 120, 62])),
    ("cell without width", "gratings.0.cells.0", lambda d: _grating(d)["cells"][0].update(rect_mm=[30, 40, 30, 62])),
    ("grating off the page", "gratings.0.rect_mm", lambda d: _grating(d).update(rect_mm=[30, 40, 151, 90])),
    ("board off the page", "board.rect_mm", lambda d: d.update(board={"rect_mm": [-1, 0, 150, 130]})),
    ("marker off the page", "markers.centers_mm.3", lambda d: d["markers"]["centers_mm"].__setitem__(3, [9.9, 114])),
    ("marker twice", "markers.ids", lambda d: d["markers"].update(ids=[7, 3, 7, 0])),
    ("marker not in its dictionary", "markers.ids", lambda d: d["markers"].update(ids=[7, 3, 100, 0])),
    ("markers on each other", "markers.centers_mm", lambda d: d["markers"]["centers_mm"].__setitem__(1, [34, 16])),
    ("markers in another order", "markers.centers_mm", lambda d: d["markers"]["centers_mm"].reverse()),
    ("frame without a line", "markers", lambda d: d.update(markers={"kind": "frame", "rect_mm": [10, 10, 140, 120]})),
    ("frame off the page", "markers.rect_mm", lambda d: d.update(markers=_frame(rect_mm=[10, 10, 160, 120]))),
    ("frame as thick as a box", "markers.line_mm", lambda d: d.update(markers=_frame(line_mm=20))),
    ("frame too thin for a far camera", "markers.line_mm", lambda d: d.update(markers=_frame(line_mm=0.45))),
    (
        "frame next to its grating",
        "lie within the frame's line",
        lambda d: (d.update(markers=_frame()), _grating(d).update(rect_mm=[5, 40, 145, 90])),
    ),
    ("notch next to the line", "notches_mm.0", lambda d: d.update(markers=_frame(notches_mm=[[20, 9, 30, 12]]))),
    ("frame like itself turned", "notches_mm", lambda d: d.update(markers=_frame(notches_mm=[[70, 11, 80, 12]]))),
    ("name of half a letter", "name", lambda d: d.update(name="\ud800")),
    ("name with a control character", "name", lambda d: d.update(name="a\x1b[31mb")),
    ("name too long", "name", lambda d: d.update(name="x" * 1001)),
    ("lens that cannot be", "half the pitch", lambda d: d["lens"].update(thickness_mm=0.5)),
    ("range from far to near", "range_m", lambda d: d.update(range_m=[2.5, 0.8])),
    ("roles for other cells", "gratings.0.code.roles", lambda d: _grating(d).update(code=_code(["reference", "beat"]))),
    ("no reference", "gratings.0.code.roles", lambda d: _grating(d).update(code=_code(["beat"]))),
    ("step of zero", "frequency_step_per_mm", lambda d: _grating(d).update(code=_code(frequency_step_per_mm=0.0))),
    ("format of tomorrow", "format", lambda d: [d.update(format=3), d.pop("markers")]),
]


@pytest.mark.parametrize(("where", "change"), [(w, c) for _, w, c in WRONG], ids=[name for name, _, _ in WRONG])
def test_what_is_wrong_is_refused_by_the_name_of_its_place(where: str, change: Callable[[Document], object]) -> None:
    """Catches: a check that is absent, and a message that leaves the place to be guessed."""
    document = by_hand()
    badge_from_json(json.dumps(document))
    coded = by_hand()
    _grating(coded)["code"] = _code()
    badge_from_json(json.dumps(coded))
    change(document)
    assert where in refusal(json.dumps(document))
