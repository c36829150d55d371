"""Badges with a coded frame in place of squares.  Each test names the fault that it catches."""

from __future__ import annotations

import pytest

from moireid.artwork.clear import areas_of
from moireid.badge import Badge, CodedFrame, badge_from_json
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS
from moireid.designer.layout import MIN_LINE_PX
from moireid.designer.reach import PHONE
from moireid.errors import DesignError, SpecError
from moireid.fabrication.page.marks import lettering_places, marker_squares
from moireid.fiducials import LEAST_UNLIKE, least_unlike

PAYLOAD = bytes.fromhex("7097c67b0fafc59b")


@pytest.fixture(scope="module", params=FORMATS)
def framed(request: pytest.FixtureRequest) -> Badge:
    return design_badge(Order("Ada", markers="frame", format=request.param), PAYLOAD)


def test_a_frame_of_each_format_is_sound_and_wide_enough(framed: Badge) -> None:
    """Catches: a layout that its own reader refuses; notches that rounding moves out of the line; a line too thin."""
    frame = framed.markers
    assert isinstance(frame, CodedFrame) and badge_from_json(framed.to_json()) == framed
    assert framed.range_m is not None
    assert frame.line_mm * PHONE.focal_px / (1000 * framed.range_m[1]) >= MIN_LINE_PX - 1e-9
    assert least_unlike(frame) > LEAST_UNLIKE + 0.1


def test_nothing_comes_near_the_line(framed: Badge) -> None:
    """Catches: fields or the board's edge where registration expects white; words set over the frame."""
    frame = framed.markers
    assert isinstance(frame, CodedFrame)
    (x0, y0, x1, y1), line, board = frame.rect_mm, frame.line_mm, framed.outline_mm
    assert min(x0 - board[0], y0 - board[1], board[2] - x1, board[3] - y1) >= 1.99 * line
    for grating in framed.gratings:
        a, b, c, d = framed.bounds_of(grating)
        assert min(a - x0, b - y0, x1 - c, y1 - d) >= 2.04 * line
    centers, half = lettering_places(framed)
    assert half >= 1.0
    assert centers[0][1] + half < y0 and centers[2][1] - half > y1
    assert [len(white) for _, white in marker_squares(framed)] == [3, 2, 1, 0]


def test_a_frame_is_refused_where_it_cannot_be() -> None:
    """Catches: turned fields that cross the line; a word that is silently taken for squares."""
    with pytest.raises(DesignError, match="squares"):
        design_badge(Order("Ada", lens="50lpi", markers="frame", axes="hex"), PAYLOAD)
    with pytest.raises(SpecError, match="squares or frame"):
        Order("Ada", lens="50lpi", markers="none")


def test_a_frame_leaves_more_room_for_fringes_on_boards_and_a5_alone(
    framed: Badge, request: pytest.FixtureRequest
) -> None:
    """Catches: what docs/decisions/tracking.md says of it, once layouts have changed."""
    name = request.node.callspec.params["framed"]
    squares = design_badge(Order("Ada", format=name), PAYLOAD)
    room, with_squares = (
        sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in areas)
        for areas in ([grating.rect_mm for grating in badge.gratings] for badge in (framed, squares))
    )
    assert (room > with_squares) == (name in ("board", "a5"))


@pytest.mark.parametrize("name", ["cr80", "a7", "a6", "a5", "board"])
def test_a_frame_leaves_room_for_name_and_id_in_every_format(name: str) -> None:
    """Catches: ends that shrink with the board while the frame's white does not."""
    badge = design_badge(Order("Ada", format=name, markers="frame"), bytes(16))
    areas = areas_of(badge)
    assert all(areas[area][3] - areas[area][1] >= least for area, least in (("head", 7 - 1e-6), ("foot", 6.5 - 1e-6)))
