"""What a badge prints so that a film shows where its page is: four squares, or a thin coded frame.

Convention: lengths in mm; page coordinates as in `badge`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from moireid.errors import SpecError
from moireid.frames import Rect
from moireid.models import read_model

Point = tuple[float, float]
Size = Annotated[float, Meta(gt=0, le=5000)]
MarkerId = Annotated[int, Meta(ge=0, le=999)]
Dictionary = Literal[
    "DICT_4X4_50",
    "DICT_4X4_100",
    "DICT_4X4_250",
    "DICT_4X4_1000",
    "DICT_5X5_50",
    "DICT_5X5_100",
    "DICT_5X5_250",
    "DICT_5X5_1000",
    "DICT_6X6_50",
    "DICT_6X6_100",
    "DICT_6X6_250",
    "DICT_6X6_1000",
]
#: A frame's least line, mm, and its widest as a share of its shorter side.
LEAST_LINE_MM, WIDEST_LINE_SHARE = 0.4, 0.1
#: Half a side is a patch of the template with 48 samples or more; far away a thinner line would have none across it.
THINNEST_LINE_SHARE = 1 / 200
#: Share of a frame's notched length by which the frame must differ from itself turned or mirrored.
LEAST_UNLIKE = 0.5


@dataclass(frozen=True)
class Markers:
    """Four ArUco markers; centers top left, top right, bottom right, bottom left of the upright page."""

    dictionary: Annotated[Dictionary, Meta(description="OpenCV's name of the set that they are from")]
    size_mm: Annotated[Size, Meta(description="side of the black square")]
    ids: Annotated[
        tuple[MarkerId, MarkerId, MarkerId, MarkerId],
        Meta(description="their numbers: top left, top right, bottom right, bottom left of the upright badge"),
    ]
    centers_mm: Annotated[
        tuple[Point, Point, Point, Point], Meta(description="their middles [x, y], in the same order")
    ]

    @property
    def dark_mm(self) -> tuple[Rect, ...]:
        """The four black squares."""
        half = self.size_mm / 2
        return tuple((x - half, y - half, x + half, y + half) for x, y in self.centers_mm)


@dataclass(frozen=True)
class CodedFrame:
    """A thin dark frame around the gratings, whose notches show which way up it is, and what page it is."""

    rect_mm: Annotated[Rect, Meta(description="outer border of its dark line")]
    line_mm: Annotated[Size, Meta(description="width of its line")]
    notches_mm: Annotated[
        tuple[Rect, ...],
        Meta(
            min_length=1,
            max_length=64,
            description="parts of the line that are left white; they show which way up it is",
        ),
    ]

    @cached_property
    def dark_mm(self) -> tuple[Rect, ...]:
        """The four sides of the frame: top and bottom from corner to corner, left and right between them."""
        (x0, y0, x1, y1), line = self.rect_mm, self.line_mm
        upper, lower = y0 + line, y1 - line
        return (x0, y0, x1, upper), (x1 - line, upper, x1, lower), (x0, lower, x1, y1), (x0, upper, x0 + line, lower)

    def notches_in(self, side: int) -> list[Rect]:
        """The notches of a side: 0 top, 1 right, 2 bottom, 3 left."""
        return [notch for notch in self.notches_mm if self.side_of(notch) == side]

    def side_of(self, notch: Rect) -> int:
        """The side that a notch lies in most."""
        return max(range(4), key=lambda k: _overlap_mm2(self.dark_mm[k], notch))


#: What a page is found by.
Fiducial = Markers | CodedFrame


class FiducialKind(Struct):
    """Which fiducial a badge has; files of before frames do not say it, and have squares."""

    kind: Annotated[Literal["squares", "frame"], Meta(description="squares in the corners, or a thin coded frame")] = (
        "squares"
    )


def read_fiducial(entry: dict[str, Any], source: str, advice: str) -> Fiducial:
    """The fiducial of a file's object `markers`.  Raises: SpecError, as `read_model`."""
    kind = read_model(entry, FiducialKind, source, advice, at="markers").kind
    if kind == "frame":
        return read_model(entry, CodedFrame, source, advice, at="markers")
    return read_model(entry, Markers, source, advice, at="markers")


def fiducial_document(fiducial: Fiducial) -> dict[str, Any]:
    """Its JSON object.  Squares have no `kind`, as readers of before frames expect."""
    own = {name: getattr(fiducial, name) for name in type(fiducial).__dataclass_fields__}
    return {"kind": "frame", **own} if isinstance(fiducial, CodedFrame) else own


def check_fiducial(
    fiducial: Fiducial, page: Rect, source: str, check_rect: Callable[[Rect, Rect, str, str], None]
) -> None:
    """Check what a schema cannot.

    Parameters: check_rect: raises unless a rectangle, the first, is in order and inside another one.
    Raises: SpecError.
    """
    if isinstance(fiducial, Markers):
        _check_squares(fiducial, source)
        for m, rect in enumerate(fiducial.dark_mm):
            check_rect(rect, page, f"markers.centers_mm.{m}", source)
        return
    check_rect(fiducial.rect_mm, page, "markers.rect_mm", source)
    x0, y0, x1, y1 = fiducial.rect_mm
    most = WIDEST_LINE_SHARE * min(x1 - x0, y1 - y0)
    least = max(LEAST_LINE_MM, THINNEST_LINE_SHARE * max(x1 - x0, y1 - y0))
    if not least <= fiducial.line_mm <= most:
        raise SpecError(
            f"{source}: markers.line_mm={fiducial.line_mm:g} must be {least:.2f} to {most:.2f} mm, from a two "
            "hundredth of the frame's longer side to a tenth of its shorter one; correct line or frame"
        )
    for n, notch in enumerate(fiducial.notches_mm):
        check_rect(notch, fiducial.dark_mm[fiducial.side_of(notch)], f"markers.notches_mm.{n}", source)
    unlike = least_unlike(fiducial)
    if unlike < LEAST_UNLIKE:
        raise SpecError(
            f"{source}: markers.notches_mm: the frame is too like itself turned or mirrored (it differs in "
            f"{100 * unlike:.0f} % of its notches, {100 * LEAST_UNLIKE:.0f} % are needed); place the notches otherwise"
        )


def check_enclosed(fiducial: Fiducial, bounds_mm: Rect, where: str, source: str) -> None:
    """Check that a grating lies within a coded frame.  Raises: SpecError."""
    if isinstance(fiducial, Markers):
        return
    (x0, y0, x1, y1), line = fiducial.rect_mm, fiducial.line_mm
    left, top, right, bottom = bounds_mm
    if left < x0 + line or top < y0 + line or right > x1 - line or bottom > y1 - line:
        raise SpecError(
            f"{source}: {where}: {[round(value, 3) for value in bounds_mm]} mm must lie within the frame's line, "
            f"{[x0 + line, y0 + line, x1 - line, y1 - line]} mm; correct that rectangle or markers.rect_mm"
        )


def least_unlike(frame: CodedFrame) -> float:
    """Share of the notched length that differs from the frame turned or mirrored, of the turn that differs least.

    Convention: sides are compared by shares of their length, as a camera's perspective hides which one is longer.
    """
    own = [_notched(frame, side) for side in range(4)]
    total = sum(end - begin for side in own for begin, end in side)
    if total <= 0:
        return 0.0
    shared = []
    for turn in range(4):
        for mirrored in (False, True):
            if not (turn or mirrored):
                continue
            # Sides run clockwise; a mirror reverses their order and each of them.
            other = [own[(turn - side) % 4 if mirrored else (side + turn) % 4] for side in range(4)]
            if mirrored:
                other = [[(1 - end, 1 - begin) for begin, end in side] for side in other]
            shared.append(sum(_common(one, two) for one, two in zip(own, other, strict=True)))
    return 1 - max(shared) / total


def _notched(frame: CodedFrame, side: int) -> list[tuple[float, float]]:
    """Notches of a side (0 top, 1 right, 2 bottom, 3 left), clockwise along it, as shares of its length."""
    (x0, y0, x1, y1), found = frame.rect_mm, []
    for notch in frame.notches_in(side):
        along = side % 2
        low, high = (x0, x1) if along == 0 else (y0, y1)
        begin, end = ((notch[along + k] - low) / (high - low) for k in (0, 2))
        found.append((begin, end) if side < 2 else (1 - end, 1 - begin))
    return found


def _common(one: list[tuple[float, float]], two: list[tuple[float, float]]) -> float:
    return sum(max(min(a[1], b[1]) - max(a[0], b[0]), 0.0) for a in one for b in two)


def _overlap_mm2(one: Rect, two: Rect) -> float:
    across, down = (min(one[k + 2], two[k + 2]) - max(one[k], two[k]) for k in (0, 1))
    return max(across, 0.0) * max(down, 0.0)


def _check_squares(markers: Markers, source: str) -> None:
    """Check that ids are in the dictionary, and that the four squares are apart and in the documented order."""
    if len(set(markers.ids)) != 4:
        raise SpecError(f"{source}: markers.ids {list(markers.ids)} repeat one; give four different ids")
    count = int(markers.dictionary.rsplit("_", 1)[1])
    if max(markers.ids) >= count:
        raise SpecError(f"{source}: markers.ids: {list(markers.ids)} must be below {count} in {markers.dictionary}")
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = markers.centers_mm
    turning = (bx - ax) * (cy - by) - (by - ay) * (cx - bx), (cx - bx) * (dy - cy) - (cy - by) * (dx - cx)
    apart = min(
        max(abs(p[0] - q[0]), abs(p[1] - q[1]))
        for k, p in enumerate(markers.centers_mm)
        for q in markers.centers_mm[:k]
    )
    if apart < markers.size_mm or min(turning) <= 0:
        raise SpecError(
            f"{source}: markers.centers_mm: {[list(c) for c in markers.centers_mm]} must be four places a marker's "
            "size or more apart, top left, top right, bottom right, bottom left"
        )
