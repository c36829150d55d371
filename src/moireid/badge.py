"""The Badge: everything that printing, filming and verifying need to know about one badge, frozen.

Convention: lengths in mm; page coordinates are those of the PDF page, origin top left, x right, y down.
Looking at the badge, z points into the page, so a camera in front of it has a negative z.
A `rect` is (x0, y0, x1, y1) with x0 < x1 and y0 < y1; those of a grating whose axis is an angle, and of its cells, lie
in the grating's own frame (`moireid.frames`).

The JSON form is `badge.json`, format 1; its JSON Schema is shipped as `moireid/schema/badge.schema.json`.
Unknown keys are ignored, so that later versions may add some.
"""

from __future__ import annotations

import hashlib
import json
import math
import unicodedata
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from moireid.errors import SpecError
from moireid.fiducials import (
    CodedFrame,
    Fiducial,
    Markers,
    Point,
    check_enclosed,
    check_fiducial,
    fiducial_document,
    fiducial_from,
)
from moireid.frames import Axis, OwnFrame, Rect, axis_from_json, bounds_of, own_frame, own_rect

if TYPE_CHECKING:
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
FORMAT = 1
#: Least step of beat frequency, cycles per mm: a smaller one could not be read from any board, so every beat would
#: pass.
MIN_STEP_PER_MM = 1e-5


@dataclass(frozen=True)
class Lens:
    """The front layer: a lenticular sheet, an array of round lenses (fly's-eye sheet), or a line mask.

    pitch_mm: spacing of lenses, both ways in an array, or of mask lines; thickness_mm: from the lens apexes (or the
    mask) to the page; radius_mm: of the lenses, None for a mask; open_fraction: clear part of a mask's pitch, None for
    a lens.
    """

    kind: Literal["lenticular", "array", "mask"]
    pitch_mm: float
    thickness_mm: float
    refractive_index: float
    radius_mm: float | None = None
    open_fraction: float | None = None

    def __post_init__(self) -> None:
        if self.kind == "mask":
            object.__setattr__(self, "open_fraction", 0.5 if self.open_fraction is None else self.open_fraction)
            return
        if self.refractive_index <= 1.0:
            raise SpecError(
                f"lens refractive_index={self.refractive_index:g} cannot focus; a lenticular sheet has more than 1"
            )
        if self.radius_mm is None:
            # A lenticular sheet for print focuses on its flat back: R = g (n - 1) / n, the paraxial thick-lens formula.
            focus_on_back_mm = self.thickness_mm * (self.refractive_index - 1.0) / self.refractive_index
            object.__setattr__(self, "radius_mm", focus_on_back_mm)
        assert self.radius_mm is not None
        # Round lenses on a square array meet where four of them do, half a diagonal from their axes.
        least_mm = self.pitch_mm / 2 * (math.sqrt(2) if self.kind == "array" else 1)
        if self.radius_mm < least_mm:
            thicker_mm = self.thickness_mm * least_mm / self.radius_mm
            finer_mm = math.floor(1e4 * self.radius_mm * self.pitch_mm / least_mm) / 1e4
            half = "half the diagonal of the pitch" if self.kind == "array" else "half the pitch"
            raise SpecError(
                f"lens radius_mm={self.radius_mm:.4g} is below {half} ({least_mm:.4g} mm), so the lenses would not "
                f"meet; raise thickness_mm to {math.ceil(1e3 * thicker_mm) / 1e3:g} or more, or "
                f"give a pitch of {finer_mm:g} mm or less",
                most_pitch_mm=finer_mm,
            )


@dataclass(frozen=True)
class Cell:
    """A part of a grating with one pitch: dark lines begin at edge_mm + k pitch_mm and are duty * pitch_mm wide."""

    rect_mm: Rect
    pitch_mm: float
    edge_mm: float
    duty: float = 0.5


@dataclass(frozen=True)
class Code:
    """How a grating's cells carry an identity; the family's module in `idcodes` defines the meaning.

    roles: one per cell, in order: "reference" (uniform, read first), "beat" (uniform, read by its beat frequency
    relative to the reference) or "phase" (lines shifted by a share of the pitch); payload_bits: carried by the whole
    badge. A beat level L has the signed design frequency base_frequency_per_mm + L frequency_step_per_mm, cycles per mm
    of page, for L below `levels`; reference_level: level of the reference cells, None if it is part of the identity.
    phase_levels: number of steps in a full turn of a phase cell.
    """

    roles: tuple[Literal["reference", "beat", "phase"], ...]
    payload_bits: int
    levels: int
    base_frequency_per_mm: float
    frequency_step_per_mm: float
    reference_level: int | None = None
    phase_levels: int | None = None

    @property
    def reference_cell(self) -> int:
        """Index of the reference cell nearest to the middle of the list."""
        places = [index for index, role in enumerate(self.roles) if role == "reference"]
        return places[len(places) // 2]


@dataclass(frozen=True)
class Grating:
    """Printed lines under one piece of lens sheet.

    axis: the direction that its fringes sense, across its lines: "x", "y", or an angle in degrees from 0 to below 180,
    from x towards y.  With an angle, `rect_mm` and those of the cells lie in the grating's own frame.

    Convention: `moireid.frames`.
    """

    rect_mm: Rect
    axis: Axis
    pitch_mm: float
    family: str
    cells: tuple[Cell, ...]
    code: Code | None = None


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
        How it is printed: "dpi", "paper", "form", "lens".

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
        return bounds_of(self.corners_of(grating))

    @property
    def squares(self) -> Markers:
        """The four squares, for what works on squares alone.  Raises: SpecError for a badge that has a frame."""
        if isinstance(self.markers, CodedFrame):
            raise SpecError("this badge has a coded frame, and four squares are needed here; give one with squares")
        return self.markers

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
                grating["cells"] = [{"rect_mm": c["rect_mm"], "duty": c["duty"]} for c in grating["cells"]]
        return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def load_badge(path: Path | str) -> Badge:
    """Read a badge.json file.

    Parameters
    ----------
    path : Path or str
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
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise SpecError(f"badge file {path} cannot be read ({reason}); give the path of a badge.json") from error
    return badge_from_json(text, source=str(path))


def badge_from_json(text: str, *, source: str = "badge.json") -> Badge:
    """Parse the text of a badge.json; `source` names it in messages.  Raises: SpecError, as `load_badge`."""
    try:
        document = json.loads(text, parse_constant=_no_constant, parse_float=_finite, parse_int=_small)
    except (ValueError, RecursionError) as error:
        raise SpecError(f"{source} is not JSON ({error}); give a file that print-your-badge wrote") from error
    _validate(document, source)
    lens = _lens(document["lens"])
    gratings = tuple(_grating(entry) for entry in document["gratings"])
    badge = Badge(
        id=document["id"],
        name=document["name"],
        page_mm=(float(document["page"]["width_mm"]), float(document["page"]["height_mm"])),
        lens=lens,
        gratings=gratings,
        markers=fiducial_from(document["markers"]),
        payload_bits=document.get("payload_bits"),
        board_mm=tuple(map(float, document["board"]["rect_mm"])) if "board" in document else None,  # type: ignore[arg-type]
        range_m=tuple(map(float, document["range_m"])) if "range_m" in document else None,  # type: ignore[arg-type]
        print=document.get("print"),
    )
    _check_geometry(badge, source)
    return badge


def _lens(entry: dict[str, Any]) -> Lens:
    """The lens from its JSON object, figures as floats."""
    figures = {key: float(entry[key]) for key in Lens.__dataclass_fields__ if key in entry and key != "kind"}
    return Lens(entry["kind"], **figures)


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is no number in JSON")


def _finite(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise ValueError(f"{digits[:40]} is no finite number")
    # 1 and 1.0 must give the same badge, and an index must be an integer.
    return int(value) if value.is_integer() and abs(value) < 2**53 else value


def _small(digits: str) -> int:
    if len(digits) > 18:
        raise ValueError(f"{digits[:18]}… has too many digits for a number here")
    return int(digits)


def _grating(entry: dict[str, Any]) -> Grating:
    """One grating from its JSON object."""
    cells = tuple(
        Cell(tuple(map(float, c["rect_mm"])), float(c["pitch_mm"]), float(c["edge_mm"]), float(c["duty"]))  # type: ignore[arg-type]
        for c in entry["cells"]
    )
    code = None
    if "code" in entry:
        given = {key: entry["code"][key] for key in Code.__dataclass_fields__ if key in entry["code"]}
        floats = {key: float(given[key]) for key in ("base_frequency_per_mm", "frequency_step_per_mm")}
        code = Code(**(given | floats | {"roles": tuple(given["roles"])}))
    return Grating(
        tuple(map(float, entry["rect_mm"])),  # type: ignore[arg-type]
        axis_from_json(entry["axis"]),
        float(entry["pitch_mm"]),
        entry["family"],
        cells,
        code,
    )


def _to_document(badge: Badge) -> dict[str, Any]:
    """The JSON object of a badge; empty keys are left out, except the id, which may be null."""
    document: dict[str, Any] = {
        "format": FORMAT,
        "id": badge.id,
        "name": badge.name,
        "page": {"width_mm": badge.page_mm[0], "height_mm": badge.page_mm[1]},
        "lens": {key: value for key, value in asdict(badge.lens).items() if value is not None},
        "gratings": [asdict(grating) for grating in badge.gratings],
        "markers": fiducial_document(badge.markers),
    }
    for grating in document["gratings"]:
        grating["code"] = {key: value for key, value in (grating["code"] or {}).items() if value is not None}
        if not grating["code"]:
            del grating["code"]
    optional = {
        "payload_bits": badge.payload_bits,
        "board": {"rect_mm": badge.board_mm} if badge.board_mm else None,
        "range_m": badge.range_m,
        "print": badge.print,
    }
    document.update({key: value for key, value in optional.items() if value is not None})
    plain: dict[str, Any] = json.loads(json.dumps(document))
    return plain


@cache
def _validator() -> Any:
    # jsonschema costs 50 ms to import, which `--help` must not pay.
    import jsonschema

    schema = json.loads(resources.files("moireid").joinpath("schema/badge.schema.json").read_text(encoding="utf-8"))
    return jsonschema.Draft202012Validator(schema)


def _validate(document: object, source: str) -> None:
    """Validate `document` by the schema; the error names the first fault."""
    if isinstance(document, dict) and document.get("format", FORMAT) != FORMAT:
        raise SpecError(
            f"{source}: format: format {document['format']!r} is not known to this version; it reads format {FORMAT}"
        )
    errors = sorted(_validator().iter_errors(document), key=lambda error: list(map(str, error.absolute_path)))
    if errors:
        where = ".".join(map(str, errors[0].absolute_path)) or "the file"
        message = errors[0].message if len(errors[0].message) < 200 else errors[0].message[:200] + " …"
        raise SpecError(f"{source}: {where}: {message}; correct that field (schema: moireid/schema/badge.schema.json)")


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
