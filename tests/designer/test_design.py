"""From a wish to a badge: what every design must hold, and whether the advice of a refusal works."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kit.payloads import payload_for_name
from moireid.badge import Badge, Cell, Code, Grating
from moireid.designer import (
    Order,
    design_badge,
    payload_from_hex,
)
from moireid.designer.design import filled
from moireid.designer.order import clean_name
from moireid.errors import CodeError, DesignError, SpecError
from moireid.names import NAME_LIMIT
from moireid.profiles import PAPERS_MM

ZOE_NFC, ZOE_NFD = "Zo\u00eb", "Zoe\u0308"
PAYLOAD = bytes.fromhex("7097c67b0fafc59b")
SHORT = bytes.fromhex("38c1c2")
#: The camera that a design must suffice for: 1080p, and a phone's angle of view.
FOCAL_PX, IMAGE_PX = 1450.0, (1920, 1080)
#: Wishes that differ in all that matters, each within what can be built.
WISHES = [
    filled(one)
    for one in (
        Order("A", lens="50lpi"),
        Order("A", lens="40lpi", range_m=(1.0, 2.0)),
        Order("A", lens="75lpi", printer_dpi=600, code="pitch"),
        Order("A", lens="60lpi", paper="letter", size_mm=(120.0, 150.0), range_m=(0.5, 1.8)),
        Order("A", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.3, 0.7)),
        Order("A", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.3, 0.7), code="pitch"),
        Order("A", lens="50lpi", size_mm=(150.0, 110.0), range_m=(0.4, 1.2), axes="xy"),
        Order("A", lens="50lpi", size_mm=(30.0, 150.0), range_m=(0.3, 0.4)),
    )
]


@pytest.fixture(params=WISHES, ids=lambda wish: f"{wish.lens}-{wish.size_mm[0]:g}x{wish.size_mm[1]:g}-{wish.code}")
def wish(request: pytest.FixtureRequest) -> Order:
    return request.param


def design(wish: Order) -> Badge:
    """A badge for the wish, with a payload of its family."""
    return design_badge(wish, SHORT if wish.code == "pitch" else PAYLOAD)


def code_of(grating: Grating) -> Code:
    assert grating.code is not None
    return grating.code


def cells_of(grating: Grating, *roles: str) -> list[Cell]:
    return [cell for cell, role in zip(grating.cells, code_of(grating).roles, strict=True) if role in roles]


def all_beats(grating: Grating) -> np.ndarray:
    """The signed beat of each level of a grating, whether or not this badge's payload uses it."""
    code = code_of(grating)
    return code.base_frequency_per_mm + code.frequency_step_per_mm * np.arange(code.levels)


def extent(grating: Grating, *, along: bool = True) -> tuple[float, float]:
    """The grating's ends along its fringes' axis, or across it."""
    k = 0 if (grating.axis == "x") == along else 1
    return grating.rect_mm[k], grating.rect_mm[k + 2]


# Every design.


def test_default_badge_is_the_published_board_with_a_code(ada: Badge) -> None:
    """Catches: defaults that drift away from the published prototype and from each other."""
    assert (ada.lens.pitch_mm, ada.lens.thickness_mm, ada.lens.refractive_index) == (0.508, 1.0, 1.56)
    assert (ada.page_mm, ada.range_m) == ((210.0, 297.0), (0.8, 2.5))
    assert (ada.markers.dictionary, ada.markers.size_mm, ada.markers.ids) == ("DICT_4X4_50", 26.0, (0, 1, 2, 3))
    assert ada.outline_mm == (32.0, 68.5, 178.0, 228.5)
    assert (ada.name, ada.id, ada.payload_bits) == ("Ada Lovelace", "7097c67b0fafc59b", 64)
    (grating,) = ada.gratings
    assert (grating.axis, grating.family) == ("x", "spacing")
    code = code_of(grating)
    reference = grating.cells[code.reference_cell]
    assert reference.pitch_mm == grating.pitch_mm
    # The reference row lies over the middle, where a twist between sheet and page moves it least.
    assert reference.rect_mm[1] <= (68.5 + 228.5) / 2 + 0.01 and reference.rect_mm[3] > (68.5 + 228.5) / 2


def test_cells_tile_the_gratings_and_everything_lies_on_the_board(wish: Order) -> None:
    """Catches: gaps or overlaps between cells, a grating over the markers, no white around them, a board off centre."""
    badge = design(wish)
    board, page = badge.outline_mm, badge.page_mm
    for grating in badge.gratings:
        area = sum((c.rect_mm[2] - c.rect_mm[0]) * (c.rect_mm[3] - c.rect_mm[1]) for c in grating.cells)
        x0, y0, x1, y1 = grating.rect_mm
        assert area == pytest.approx((x1 - x0) * (y1 - y0), rel=1e-6)
        for a, b in itertools.combinations(grating.cells, 2):
            overlap = [min(a.rect_mm[2 + k], b.rect_mm[2 + k]) - max(a.rect_mm[k], b.rect_mm[k]) for k in (0, 1)]
            assert min(overlap) < 1e-6
        # Uniform rows run from end to end, because their length is what separates beat frequencies.
        for cell in cells_of(grating, "reference", "beat"):
            k = 0 if grating.axis == "x" else 1
            assert (cell.rect_mm[k], cell.rect_mm[k + 2]) == pytest.approx(extent(grating))
    for a, b in itertools.combinations(badge.gratings, 2):
        assert a.rect_mm[2] < b.rect_mm[0]
    assert (board[0] + board[2], board[1] + board[3]) == pytest.approx(page)
    assert (board[2] - board[0], board[3] - board[1]) == pytest.approx(wish.size_mm)
    half = badge.markers.size_mm / 2
    module = badge.markers.size_mm / 6
    for k, (x, y) in enumerate(badge.markers.centers_mm):
        assert board[0] < x - half and x + half < board[2] and board[1] < y - half and y + half < board[3]
        # OpenCV asks for a white module around a marker.
        for grating in badge.gratings:
            white = grating.rect_mm[1] - (y + half) if k < 2 else (y - half) - grating.rect_mm[3]
            assert white >= module
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = badge.markers.centers_mm
    assert x0 == x3 < x1 == x2 and y0 == y1 < y2 == y3
    assert x1 - x0 - 2 * half >= 2 * module


def test_every_levels_beat_stays_readable_as_built(wish: Order) -> None:
    """Catches: tolerances left out, or applied at one end; magnitudes that cross zero; a far end out of sight.

    Built: the print 0.5 % and the sheet 0.3 % off, either way.  In page units the page's pitch stays what it is, and
    the sheet's frequency changes by both.
    """
    badge = design(wish)
    px_per_mm = FOCAL_PX / (1000.0 * wish.range_m[1])
    for grating in badge.gratings:
        length, beats = extent(grating)[1] - extent(grating)[0], all_beats(grating)
        for print_scale, sheet_scale in itertools.product((0.995, 1.005), (0.997, 1.003)):
            built = beats + 1 / badge.lens.pitch_mm - print_scale / (badge.lens.pitch_mm * sheet_scale)
            assert np.all(built < 0)
            assert np.abs(built).min() * length >= 2.0 - 0.01
            assert px_per_mm / np.abs(built).max() >= 5.0 - 0.02


def test_levels_are_far_enough_apart_and_the_far_end_sees_them(wish: Order) -> None:
    """Catches: levels squeezed into what is left; markers, rows or cells too small to see at the far end."""
    badge = design(wish)
    px_per_mm = FOCAL_PX / (1000.0 * wish.range_m[1])
    shortest = min(extent(grating)[1] - extent(grating)[0] for grating in badge.gratings)
    for grating in badge.gratings:
        steps = np.abs(np.diff(all_beats(grating)))
        assert steps == pytest.approx([steps[0]] * (15 if wish.code == "pitch" else 7))
        assert 0.40 - 1e-9 <= steps[0] * shortest <= 0.55 + 1e-9
        for cell in grating.cells:
            sides = cell.rect_mm[2] - cell.rect_mm[0], cell.rect_mm[3] - cell.rect_mm[1]
            assert min(sides) * px_per_mm >= 3.0
        across = 1 if grating.axis == "x" else 0
        for cell in cells_of(grating, "reference", "beat"):
            assert (cell.rect_mm[across + 2] - cell.rect_mm[across]) * px_per_mm >= 4.0
    assert badge.markers.size_mm * px_per_mm >= 14.0
    board = [badge.outline_mm[2 + k] - badge.outline_mm[k] for k in (0, 1)]
    near_px_per_mm = FOCAL_PX / (1000.0 * wish.range_m[0])
    assert board[0] * near_px_per_mm <= IMAGE_PX[0] and board[1] * near_px_per_mm <= IMAGE_PX[1]


@pytest.mark.parametrize("family", ["spacing", "pitch"])
def test_two_people_have_one_layout_and_different_lines(family: str) -> None:
    """Catches: a layout that depends on name or payload, which a reader without a claim could not know."""
    ada, bob = (
        design_badge(Order(name, lens="50lpi", code=family), payload_for_name(name, family=family))
        for name in ("Ada", "Bob")
    )
    assert ada.layout_key() == bob.layout_key()
    lines = [[(cell.pitch_mm, cell.edge_mm) for cell in badge.gratings[0].cells] for badge in (ada, bob)]
    assert lines[0] != lines[1]
    assert ada.gratings[0].code == bob.gratings[0].code


# What cannot be done, and whether the advice works.


def follow(request: Order, message: str) -> Order:
    """The request changed as the message says, and in nothing else."""
    if found := re.search(r"range within ([\d.]+)-([\d.]+) m", message):
        near, far = float(found[1]), float(found[2])
        return replace(request, range_m=tuple(min(max(end, near), far) for end in request.range_m))
    if found := re.search(r"end the range at ([\d.]+) m", message):
        return replace(request, range_m=(request.range_m[0], float(found[1])))
    if found := re.search(r"begin the range at ([\d.]+) m", message):
        return replace(request, range_m=(float(found[1]), request.range_m[1]))
    if found := re.search(r"print at (\d+) dpi", message):
        return replace(request, printer_dpi=int(found[1]))
    if found := re.search(r"at most ([\d.]+) x ([\d.]+) mm", message):
        limits = float(found[1]), float(found[2])
        return replace(request, size_mm=tuple(min(a, b) for a, b in zip(request.size_mm, limits, strict=True)))
    if found := re.search(r"at least (\d+)x(\d+)|such as (\d+)x(\d+)", message):
        size = [float(side) for side in found.groups() if side]
        return replace(request, size_mm=tuple(max(a, b) for a, b in zip(request.size_mm, size, strict=True)))
    if found := re.search(r"choose one of (\w+)", message):
        known = found[1]
        return replace(request, paper=known) if known in PAPERS_MM else replace(request, lens=known)
    raise AssertionError(f"no advice in: {message}")


def asked(**wish: Any) -> Order:
    """A wish for the prototype's board and range, but for what is given."""
    return Order("A", **{"lens": "50lpi", "size_mm": (146.0, 160.0), "range_m": (0.8, 2.5)} | wish)


@pytest.mark.claim("The advice of a refusal leads to a badge")
@pytest.mark.parametrize(
    "request_",
    [
        asked(range_m=(0.8, 4.6)),
        asked(range_m=(0.8, 1e6)),
        asked(range_m=(3.0, 9.0)),
        asked(range_m=(0.05, 2.0)),
        asked(range_m=(0.001, 0.002)),
        asked(size_mm=(60.0, 66.0)),
        asked(size_mm=(1.0, 1.0)),
        asked(size_mm=(146.0, 50.0)),
        asked(size_mm=(12.0, 160.0)),
        asked(size_mm=(24.0, 160.0)),
        asked(size_mm=(150.0, 60.0), range_m=(0.3, 2.0)),
        asked(size_mm=(400.0, 400.0)),
        asked(size_mm=(400.0, 400.0), paper="letter", range_m=(0.1, 5.0)),
        asked(size_mm=(40.0, 300.0), paper="letter"),
        asked(printer_dpi=72),
        asked(lens="75lpi", printer_dpi=300, range_m=(0.1, 4.0)),
        asked(lens="55lpi"),
    ],
    ids=lambda r: f"{r.lens}-{r.paper}-{r.size_mm[0]:g}x{r.size_mm[1]:g}-{r.range_m[0]:g}-{r.range_m[1]:g}",
)
def test_following_the_advice_of_a_refusal_leads_to_a_badge(request_: Order) -> None:
    """Catches: advice that is rounded to the wrong side, contradicts itself, or only leads to the next wall."""
    with pytest.raises((DesignError, SpecError)) as refused:
        design_badge(request_, PAYLOAD)
    message = str(refused.value)
    for _ in range(3):
        request_ = follow(request_, message)
        assert 0 < request_.range_m[0] <= request_.range_m[1], message
        try:
            badge = design_badge(request_, PAYLOAD)
        except (DesignError, SpecError) as error:
            message = str(error)
            continue
        assert badge.range_m == request_.range_m
        return
    raise AssertionError(f"three pieces of advice led to: {message}")


def test_a_refused_range_names_the_least_board_that_serves() -> None:
    """Catches: "a larger board" without its size; one that is refused in turn; one where none serves."""
    far = asked(lens="62lpi-27mil", range_m=(0.8, 4.5))
    with pytest.raises(DesignError, match=r"or give size_mm=200x219 paper=a3$"):
        design_badge(far, PAYLOAD)
    larger = replace(far, size_mm=(200.0, 219.0), paper="a3")
    assert design_badge(larger, PAYLOAD).range_m == (0.8, 4.5)
    with pytest.raises(DesignError, match="read at"):
        design_badge(replace(larger, size_mm=(198.0, 218.0)), PAYLOAD)
    # Beyond A3 a print shop's paper, and a coarser lens sheet where that takes less of it; at last another camera.
    with pytest.raises(DesignError, match=r"or give size_mm=288x315 paper=sra3 lens=30lpi-47mil$"):
        design_badge(replace(far, range_m=(3.0, 8.0)), PAYLOAD)
    shops = replace(far, range_m=(3.0, 8.0), size_mm=(288.0, 315.0), paper="sra3", lens="30lpi-47mil")
    badge = design_badge(shops, PAYLOAD)
    assert badge.range_m == (3.0, 8.0) and badge.page_mm == PAPERS_MM["sra3"] and len(badge.gratings) == 1
    with pytest.raises(DesignError, match=r"no board up to A1 .* a lens of 104 mm"):
        design_badge(replace(far, range_m=(3.0, 15.0)), PAYLOAD)


# Names and payloads.


def test_a_name_is_one_however_it_is_encoded() -> None:
    """Catches: a badge of the bytes typed; macOS hands out NFD, a keyboard gives NFC."""
    assert design_badge(Order(ZOE_NFD, lens="50lpi"), PAYLOAD).name == ZOE_NFC


@pytest.mark.parametrize("family", ["spacing", "pitch"])
@pytest.mark.parametrize(
    "text",
    [
        "",
        "3fa2",
        "3fa20g",
        "٣fa20c",
        "3fa20c\n",
        "01 23 45 67 89 a",
    ],
)
def test_what_is_no_payload_is_refused(family: str, text: str) -> None:
    """Catches: bytes.fromhex, which overlooks spaces and so makes two bytes of six characters."""
    with pytest.raises(CodeError, match="6 hex digits" if family == "pitch" else "16 or 32 hex digits"):
        payload_from_hex(text, family=family)


@pytest.mark.parametrize(
    "name",
    [
        "",
        "a\nb",
        "\x1b[31mred",
        "\ud800",
        "x" * (NAME_LIMIT + 1),
        "\u200b",
        "a\u2028b",
        "Ada \u202eevil",
    ],
    ids=ascii,
)
def test_names_that_cannot_be_set_or_typed_are_refused(name: str) -> None:
    """Catches: control characters on paper, a name that shows nothing, one that turns the writing round."""
    with pytest.raises(SpecError, match="name"):
        clean_name(name)
    with pytest.raises(SpecError, match="name"):
        design_badge(Order(name, lens="50lpi"), PAYLOAD)
