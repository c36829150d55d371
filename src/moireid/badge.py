"""The Badge: everything that printing, filming and verifying need to know about one badge, frozen.

Convention: lengths in mm; page coordinates are those of the PDF page, origin top left, x right, y down.
Looking at the badge, z points into the page, so a camera in front of it has a negative z.
A `rect` is (x0, y0, x1, y1) with x0 < x1 and y0 < y1; those of a grating whose axis is an angle, and of its cells, lie
in the grating's own frame (`moireid.frames`).

The JSON form is `badge.json`, format 1, or 2 with smooth fields; its JSON Schema is shipped as
`moireid/schema/badge.schema.json`.
Unknown keys are ignored, so that later versions may add some.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import unicodedata
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal

from msgspec import Meta, Struct, to_builtins

from moireid.errors import SpecError
from moireid.fiducials import (
    CodedFrame,
    Fiducial,
    Markers,
    Point,
    Size,
    check_enclosed,
    check_fiducial,
    fiducial_document,
    read_fiducial,
)
from moireid.files import AnyPath, as_path, read_regular
from moireid.frames import OwnFrame, Rect, own_frame, own_rect
from moireid.layers import Bits, Cell, Code, Grating, Lens, is_smooth
from moireid.lazy import from_room
from moireid.models import check_format, parse_json, read_model

if TYPE_CHECKING:
    from PIL import Image

    from moireid.frames import Array

__all__ = [
    "FORMAT",
    "Badge",
    "Cell",
    "Code",
    "CodedFrame",
    "Fiducial",
    "Grating",
    "Lens",
    "Markers",
    "Point",
    "Rect",
    "badge_from_json",
    "load_badge",
]
#: Smooth fields came with format 2; a badge without one is written in format 1, which older versions read.
FORMAT, SMOOTH_FORMAT = 1, 2
ADVICE = "correct that field (schema: moireid/schema/badge.schema.json)"
#: Least step of beat frequency, cycles per mm: a smaller one could not be read from any board, so every beat would
#: pass.
MIN_STEP_PER_MM = 1e-5


@dataclass(frozen=True)
class Badge:
    """One badge as issued; never changed afterwards.

    Parameters
    ----------
    id : str or None
        The identity as lower-case hex digits; None for a board without one, such as a pitch test sheet.
    name : str
        Who wears it.
    page_mm : (float, float)
        Width and height of the printed page, mm.
    lens : Lens
        The lenticular sheet or the line mask in front.
    gratings : tuple of Grating
        The printed lines, one grating for each direction that they sense.
    markers : Markers or CodedFrame
        What a film finds the page by: four squares in the corners, or a thin frame.
    payload_bits : int, optional
        Bits of the identity.
    board_mm : Rect, optional
        The board that is cut out of the page, (x0, y0, x1, y1), page mm.
    range_m : (float, float), optional
        Nearest and farthest camera, m.
    print : dict, optional
        How it is printed: "dpi", "paper", "form", "lens", and "ink_growth_um" where its lines are drawn narrower.
    look : moireid.artwork.placing.Look, optional
        What it is to wear when it is printed; it is not in badge.json, and no part of what makes a badge this one.

    Notes
    -----
    Convention: page mm have their origin at the page's top left, x right, y down.
    """

    id: str | None
    name: str
    page_mm: tuple[float, float]
    lens: Lens
    gratings: tuple[Grating, ...]
    markers: Fiducial
    payload_bits: int | None = None
    board_mm: Rect | None = None
    range_m: tuple[float, float] | None = None
    print: dict[str, Any] | None = field(default=None, hash=False)
    look: Any = field(default=None, compare=False)

    def __repr__(self) -> str:
        """Short, as all its cells would be 16 kB."""
        (x0, y0, x1, y1), cells = self.outline_mm, sum(len(grating.cells) for grating in self.gratings)
        return f"Badge({self.name!r}, id={self.id!r}, {x1 - x0:g} x {y1 - y0:g} mm, {cells} cells)"

    @property
    def outline_mm(self) -> Rect:
        """The board that is cut out of the page; the whole page if none is given."""
        return self.board_mm or (0.0, 0.0, *self.page_mm)

    def frame_of(self, grating: Grating) -> OwnFrame:
        """The own frame of one of its gratings (`moireid.frames`)."""
        return own_frame(grating.axis, self.page_mm)

    def corners_of(self, grating: Grating) -> Array:
        """The four corners of one of its gratings on the page, (4, 2), mm."""
        return self.frame_of(grating).corners_mm(own_rect(grating.axis, grating.rect_mm))

    def bounds_of(self, grating: Grating) -> Rect:
        """The upright rectangle of the page that holds one of its gratings."""
        return self.frame_of(grating).bounds_mm(own_rect(grating.axis, grating.rect_mm))

    @property
    def squares(self) -> Markers:
        """The four squares, for what works on squares alone.  Raises: SpecError for a badge that has a frame."""
        if isinstance(self.markers, CodedFrame):
            raise SpecError("this badge has a coded frame, and four squares are needed here; give one with squares")
        return self.markers

    def show(self) -> Image.Image:
        """Draw the badge as a camera sees it from 1 m.

        Returns
        -------
        PIL.Image.Image
            What a notebook shows; its `show` opens a window, and its `save` writes a file.
        """
        drawn: Image.Image = from_room("moireid.fabrication.page.preview", "draw_preview")(self)
        return drawn

    def _repr_png_(self) -> bytes:
        """For notebooks."""
        out = io.BytesIO()
        self.show().save(out, format="PNG")
        return out.getvalue()

    def to_json(self) -> str:
        """Give the text of a badge.json file.

        Returns
        -------
        str
            Readable JSON, with a final newline.
        """
        return json.dumps(_to_document(self), indent=1, ensure_ascii=False) + "\n"

    def layout_key(self) -> str:
        """Hash all that a reader must know before it reads the identity: two badges of one layout read alike.

        Returns
        -------
        str
            SHA-256, hex digits.
        """
        document = _to_document(self)
        for key in ("id", "name", "print", "range_m"):
            document.pop(key, None)
        for grating in document["gratings"]:
            grating.pop("pitch_mm")
            if "code" in grating:
                written = "pitch_mm", "edge_mm"
                grating["cells"] = [{k: v for k, v in c.items() if k not in written} for c in grating["cells"]]
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def load_badge(path: AnyPath) -> Badge:
    """Read a badge.json file.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Badge
        Checked against the schema and for its geometry.

    Raises
    ------
    SpecError
        Where the file is absent, not JSON, or breaks the schema or the geometry; the message names the key and what is
        allowed there.
    """
    path = as_path(path)
    try:
        content = read_regular(path)
        text = content.decode(json.detect_encoding(content))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "no Unicode text"
        raise SpecError(f"badge file {path} cannot be read ({reason}); give the path of a badge.json") from error
    return badge_from_json(text, source=str(path))


Distance = Annotated[float, Meta(gt=0, le=100)]


class Page(Struct):
    """The sheet of paper."""

    width_mm: Annotated[Size, Meta(description="its width")]
    height_mm: Annotated[Size, Meta(description="its height")]


class Board(Struct):
    """What is cut out and worn."""

    rect_mm: Rect


class BadgeFile(Struct):
    """What badge.json holds.  Lengths in mm; page coordinates with origin top left, x right, y down."""

    format: Annotated[Literal[1, 2], Meta(description="the version of this format: 2 where cells blend, else 1")]
    id: Annotated[
        Annotated[str, Meta(pattern="^([0-9a-f]{2}){1,16}$")] | None,
        Meta(description="the payload, lower-case hex; null for a board made elsewhere"),
    ]
    name: Annotated[str, Meta(max_length=1000, description="the holder's name, as printed")]
    page: Page
    lens: Lens
    gratings: Annotated[tuple[Grating, ...], Meta(min_length=1, max_length=16, description="the striped fields")]
    markers: Annotated[dict[str, Any], Meta(description="what a film shows the page by: squares or a frame")]
    payload_bits: Annotated[Bits | None, Meta(description="length of the identity, on badges that moireid issued")] = (
        None
    )
    board: Annotated[Board | None, Meta(description="the whole page if it is missing")] = None
    range_m: Annotated[
        tuple[Distance, Distance] | None,
        Meta(description="nearest and farthest camera that it was designed for, m"),
    ] = None
    print: Annotated[dict[str, Any] | None, Meta(description="how it was printed: dpi and more")] = None


def badge_from_json(text: str, *, source: str = "badge.json") -> Badge:
    """Parse the text of a badge.json; `source` names it in messages.  Raises: SpecError, as `load_badge`."""
    document = parse_json(text, source, "give a file that print-your-badge wrote")
    check_format(document, (FORMAT, SMOOTH_FORMAT), source)
    file = read_model(document, BadgeFile, source, ADVICE)
    badge = Badge(
        id=file.id,
        name=file.name,
        page_mm=(file.page.width_mm, file.page.height_mm),
        lens=file.lens,
        gratings=file.gratings,
        markers=read_fiducial(file.markers, source, ADVICE),
        payload_bits=file.payload_bits,
        board_mm=file.board.rect_mm if file.board else None,
        range_m=file.range_m,
        print=file.print,
    )
    _check_geometry(badge, source)
    return badge


def _to_document(badge: Badge) -> dict[str, Any]:
    """The JSON object of a badge; empty keys are left out, except the id, which may be null."""
    optional = {
        "payload_bits": badge.payload_bits,
        "board": {"rect_mm": badge.board_mm} if badge.board_mm else None,
        "range_m": badge.range_m,
        "print": badge.print,
    }
    document: dict[str, Any] = to_builtins(
        {
            "format": SMOOTH_FORMAT if any(is_smooth(grating) for grating in badge.gratings) else FORMAT,
            "id": badge.id,
            "name": badge.name,
            "page": {"width_mm": badge.page_mm[0], "height_mm": badge.page_mm[1]},
            "lens": badge.lens,
            "gratings": badge.gratings,
            "markers": fiducial_document(badge.markers),
        }
        | {key: value for key, value in optional.items() if value is not None}
    )
    document["lens"] = _without_empty(document["lens"])
    for grating in document["gratings"]:
        code = _without_empty(grating.pop("code", None) or {})
        grating |= {"code": code} if code else {}
        for cell in grating["cells"]:
            if not any(cell.get("blend_mm", ())):
                cell.pop("blend_mm", None)
    return document


def _without_empty(document: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in document.items() if value is not None}


def _check_geometry(badge: Badge, source: str) -> None:
    """Check what a schema cannot: rectangles in order and on the page, cells within gratings, markers apart."""
    if badge.id is not None and badge.id != badge.id.strip():
        raise SpecError(f"{source}: id: {badge.id!r} holds space; give hex digits alone")
    if any(unicodedata.category(letter) in ("Cc", "Cs") for letter in badge.name):
        raise SpecError(
            f"{source}: name: {badge.name[:40]!r} holds control characters or half letters; give plain text"
        )
    if badge.range_m and badge.range_m[0] > badge.range_m[1]:
        raise SpecError(
            f"{source}: range_m: {list(badge.range_m)} runs from far to near; give the nearer distance first"
        )
    page: Rect = (0.0, 0.0, *badge.page_mm)
    if badge.board_mm:
        _check_rect(badge.board_mm, page, "board.rect_mm", source)
    for g, grating in enumerate(badge.gratings):
        rect = grating.rect_mm
        _check_rect(rect, (-math.inf, -math.inf, math.inf, math.inf), f"gratings.{g}.rect_mm", source)
        _check_rect(badge.bounds_of(grating), page, f"gratings.{g}.rect_mm on the page", source)
        for c, cell in enumerate(grating.cells):
            _check_rect(cell.rect_mm, rect, f"gratings.{g}.cells.{c}.rect_mm", source)
        if is_smooth(grating):
            _check_smooth(grating, g, source)
        if grating.code and abs(grating.code.frequency_step_per_mm) < MIN_STEP_PER_MM:
            raise SpecError(
                f"{source}: gratings.{g}.code.frequency_step_per_mm={grating.code.frequency_step_per_mm:g} is too "
                f"small to be read; at least {MIN_STEP_PER_MM:g} is needed"
            )
        if grating.code and (len(grating.code.roles) != len(grating.cells) or "reference" not in grating.code.roles):
            raise SpecError(
                f"{source}: gratings.{g}.code.roles must name one role for each of the {len(grating.cells)} cells, and "
                f"one of them reference; got {len(grating.code.roles)}"
            )
    check_fiducial(badge.markers, page, source, _check_rect)
    for g, grating in enumerate(badge.gratings):
        check_enclosed(badge.markers, badge.bounds_of(grating), f"gratings.{g}.rect_mm", source)


def _check_smooth(grating: Grating, number: int, source: str) -> None:
    """Raise unless the cells of a smooth grating are rows that fill it, reach half of themselves at most, and are dark
    by one share.
    """
    rects = sorted(((own_rect(grating.axis, cell.rect_mm), cell) for cell in grating.cells), key=lambda one: one[0])
    area = sum((rect[2] - rect[0]) * (rect[3] - rect[1]) for rect, _ in rects)
    low, begin, high, end = own_rect(grating.axis, grating.rect_mm)
    rows: dict[float, list[Rect]] = {}
    for rect, _ in rects:
        rows.setdefault(round(rect[1], 4), []).append(rect)
    joined = all(
        abs(row[0][0] - low) < 1e-6 and abs(row[-1][2] - high) < 1e-6 and len({round(one[3], 4) for one in row}) == 1
        for row in rows.values()
    )
    filled = joined and abs(area - (high - low) * (end - begin)) < 1e-4
    reach = all(cell.blend_mm[k] <= (rect[k + 2] - rect[k]) / 2 + 1e-6 for rect, cell in rects for k in (0, 1))
    if not (filled and reach and len({cell.duty for cell in grating.cells}) == 1):
        raise SpecError(
            f"{source}: gratings.{number}.cells: cells that blend must be rows that fill the grating, with blend_mm of "
            "half their sides at most and one duty; correct them"
        )


def _check_rect(rect: Rect, outer: Rect, where: str, source: str) -> None:
    """Raise unless `rect` is in order and inside `outer`, with room for rounding."""
    slack_mm = 1e-6
    inside = (
        rect[0] >= outer[0] - slack_mm
        and rect[1] >= outer[1] - slack_mm
        and rect[2] <= outer[2] + slack_mm
        and rect[3] <= outer[3] + slack_mm
    )
    if not (all(map(math.isfinite, rect)) and rect[0] < rect[2] and rect[1] < rect[3] and inside):
        raise SpecError(
            f"{source}: {where}: {[round(v, 4) for v in rect]} mm must be x0 < x1, y0 < y1 within "
            f"{[round(v, 4) for v in outer]} mm; correct that rectangle"
        )
