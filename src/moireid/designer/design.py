"""The choice of beat frequencies and cells, and the Badge.

The slowest beat must keep enough fringes in the grating to be distinguished from shading, even if print scale and lens
pitch are off by their tolerances.  The fastest must keep enough pixels in a fringe at the far end of the range.  The
beat levels divide the interval between the two.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from moireid.badge import Badge, Cell, Code, Grating, Lens
from moireid.designer.formats import PHONE_MM, format_named, turned
from moireid.designer.grid import DUTY, Grid, bands, cells_and_roles, choose_grid
from moireid.designer.layout import Layout, lay_out, page_for
from moireid.designer.order import DESIGN_FOCAL_PX, FAMILY_BYTES, GAP_MM, Order, Pair
from moireid.designer.reach import (
    MIN_FRINGES,
    MIN_PX_PER_FRINGE,
    PITCH_TOLERANCE,
    check_range,
    fringe_length_mm,
)
from moireid.dots import realised
from moireid.errors import CodeError, DesignError, SpecError
from moireid.files import as_path
from moireid.idcodes import CodeFamily, family_named
from moireid.idcodes.pitch import BANDS
from moireid.idcodes.pitch import LEVELS as PITCH_LEVELS
from moireid.idcodes.spacing import PHASE_LEVELS
from moireid.materials import materials
from moireid.optics import rear_pitch_for_beat_mm
from moireid.profiles import PAPERS_MM, lens_named, mask_named
from moireid.sheets import MM_PER_INCH, PRODUCTS, sheet_lens

#: More spacing of levels than this many fringes across the grating only shortens the fringes.
MAX_STEP_FRINGES = 0.55
#: A printed line narrower than this many dots has no dependable width.
MIN_DOTS_PER_LINE = 3.0
#: A symbol is confused beyond pi / 4; rounding to dots may take this much of it, the rest is for the film.
MAX_DOT_PHASE_RAD = 0.25
#: Times a phone's focal length: 135 mm, the longest lens of the table of distances; the verifier solves up to it.
LONGEST = 5.0
#: Sizes of boards that are tried where one is too small, of its own.
PERCENTS = range(102, 1000)
#: Resolutions that printers have; beyond 1200 dpi no line of a lens sheet's pitch can be off by so much.
PRINTER_DPI = (300, 360, 400, 600, 720, 1200, 1440, 2400)
#: Beat levels of the spacing family's uniform rows.
SPACING_LEVELS = 8
#: A range may be too wide for several reasons, and each attempt reports only one of them.
MOST_CUTS = 4
#: Whose pitch a mask has where no lens is named.
MASK_LENS = "50lpi"
#: How the lines of neighbouring cells meet.
PATTERNS = ("cells", "silk")
#: The published prototype's printed pitch is 1.0236 lens pitches; the pitch family's reference keeps near that ratio.
REFERENCE_RATIO = 0.52 / 0.508


@dataclass(frozen=True)
class Drawing:
    """An order with all that is chosen for it but the identity: its code family, front, places, grid and beats.

    slowest_per_mm, step_per_mm: beat frequency of the slowest level, and step of levels, magnitudes in cycles per mm.
    """

    order: Order
    family: CodeFamily
    lens: Lens
    layout: Layout
    grid: Grid
    slowest_per_mm: float
    step_per_mm: float
    levels: int
    payload_bytes: int

    @property
    def spacing(self) -> bool:
        """Whether the code is in the places of lines."""
        return self.family.name == "spacing"


def design_badge(order: Order, payload: bytes) -> Badge:
    """Design the badge that carries a payload and can be read over the order's range.

    Parameters
    ----------
    order : Order
        Whose badge, on which sheet and printer, read from how far; its own payload does not count.
    payload : bytes
        Its identity, 8 or 16 bytes, or 3 of the pitch family.

    Returns
    -------
    Badge
        All that printing, filming and verifying need.

    Raises
    ------
    SpecError
        For a lens or a format that is none.
    DesignError
        Where nothing works; it names what would.
    CodeError
        Where the payload does not fit.

    Notes
    -----
    Convention: printed pitches are coarser than the lens pitch, so beats are negative, as in the published prototype.
    Source: `choose_beats`; p_r = 1 / (1/p_f + f_b).
    """
    order = filled(order, len(payload))
    try:
        drawing = _drawing(order, len(payload))
    except DesignError as error:
        if "size_mm" in error.details or "far_m" not in error.details:
            raise
        raise DesignError(f"{error}{_larger(order, len(payload), error)}", **error.details) from error
    layout, lens_pitch_mm = drawing.layout, drawing.lens.pitch_mm
    silk = _is_silk(order, drawing.family.name)
    blank = tuple(_blank_grating(drawing, k, silk=silk) for k in range(len(layout.fields_mm)))
    _check_printer(order, blank[0].pitch_mm)
    gratings = tuple(
        Grating(g.rect_mm, g.axis, _reference_pitch_mm(g, cells), g.family, cells, g.code)
        for g, cells in zip(blank, drawing.family.write(payload, blank, lens_pitch_mm), strict=True)
    )
    _check_dots(order, gratings, lens_pitch_mm)
    return Badge(
        id=payload.hex(),
        name=order.name,
        page_mm=layout.page_mm,
        lens=drawing.lens,
        gratings=gratings,
        markers=layout.markers,
        payload_bits=8 * len(payload),
        board_mm=layout.board_mm,
        range_m=order.range_m,
        # Of a lens profile only the file's name: its folder is private.
        print={"dpi": order.printer_dpi, "paper": order.paper, "form": order.form}
        | {"lens": Path(order.lens or "").name}
        | ({"ink_growth_um": order.ink_growth_um} if order.ink_growth_um else {}),
    )


def filled(order: Order, payload_bytes: int | None = None) -> Order:
    """The order with size, lens and range of its format where it names none, the range as far as the board is read.

    Parameters: payload_bytes: length of the identity; None for the shortest one.
    Raises: SpecError for a size of a format; DesignError where no part of the format's range works.
    """
    form = format_named(order.format)
    size_mm = turned(form.size_mm, order.orientation)
    own = order.format is None and order.orientation is None
    if order.size_mm not in (None, size_mm) and not own:
        raise SpecError("size_mm= is for a badge of no format; give it without format= and orientation=")
    # A mask is of any pitch.
    lens = order.lens or (MASK_LENS if own and order.front == "mask" else form.lens)
    full = replace(order, size_mm=order.size_mm or size_mm, lens=lens, range_m=order.range_m or form.range_m)
    if order.range_m is not None:
        return full
    length = payload_bytes or FAMILY_BYTES[order.code or "spacing"][0]
    for _ in range(MOST_CUTS):
        try:
            _drawing(full, length)
        except DesignError as error:
            full = replace(full, range_m=_cut(full.range_m or form.range_m, error))
        else:
            break
    return full


def _larger(order: Order, payload_bytes: int, error: DesignError) -> str:
    """What else to do: the least board of that shape that serves, with a coarser lens sheet where that saves
    paper of a print shop; a longer lens of the camera where none serves.

    Parameters: error: that of `check_range`.
    """
    assert order.range_m is not None
    papers, wishes = list(PAPERS_MM), [order]
    if order.front == "lens":
        sheets = [(PRODUCTS[row.label], row.label) for row in materials() if row.label and row.sold]
        coarser = [one for one in sheets if one[0].pitch_mm > _front(order).pitch_mm]
        coarser.sort(key=lambda one: (one[0].pitch_mm, one[0].thickness_mm))
        wishes += [replace(order, lens=label, lens_thickness_mm=None) for _, label in coarser]
    if boards := [board for wish in wishes if (board := _least_board(wish, payload_bytes))]:
        # Of those alike, `min` takes the first: the order's own sheet, and then the finest and thinnest.
        board = min(boards, key=lambda board: max(papers.index(board.paper), papers.index("a3")))
        paper = f" paper={board.paper}" if board.paper != order.paper else ""
        lens = f" lens={board.lens}" if board.lens != order.lens else ""
        return ", or give size_mm={:g}x{:g}".format(*board.size_mm or ()) + paper + lens
    longer = order.range_m[1] / float(str(error.details["far_m"]))
    if not 1 < longer <= LONGEST:
        return ""
    lens_mm = math.ceil(PHONE_MM * longer)
    return f"; no board up to {papers[-1].upper()} is read so far: film with a lens of {lens_mm} mm, not {PHONE_MM:g}"


def _least_board(order: Order, payload_bytes: int) -> Order | None:
    """The order for the least board of that shape that is read over the range, on the least paper; None for none.

    Source: larger boards are read farther, so it is found by halving.
    """
    assert order.size_mm is not None and order.range_m is not None
    width, height, far_m = *order.size_mm, order.range_m[1]

    def wish(percent: int) -> Order:
        size_mm = float(round(width * percent / 100)), float(round(height * percent / 100))
        papers = dict.fromkeys((order.paper, *PAPERS_MM))
        paper = next((one for one in papers if page_for(one, *size_mm)), order.paper)
        return replace(order, format=None, orientation=None, size_mm=size_mm, paper=paper)

    def reaches(percent: int) -> bool:
        try:
            _drawing(wish(percent), payload_bytes)
        except DesignError as error:
            # What no paper holds is no smaller than what serves.
            return float(str(error.details.get("far_m", far_m))) >= far_m
        return True

    least = PERCENTS[bisect_left(PERCENTS, True, hi=len(PERCENTS) - 1, key=reaches)]
    with suppress(DesignError):
        _drawing(wish(least), payload_bytes)
        return wish(least)
    return None


def _cut(range_m: Pair, error: DesignError) -> Pair:
    """The part of a range that a board allows, by the error of `check_range`.  Raises: the error where it has none."""
    near_m, far_m = error.details.get("near_m", range_m[0]), error.details.get("far_m")
    if not isinstance(near_m, float) or not isinstance(far_m, float):
        raise error
    cut = max(range_m[0], near_m), min(range_m[1], math.floor(100 * far_m) / 100)
    if cut[0] >= cut[1] or cut == range_m:
        raise error
    return cut


def _drawing(order: Order, payload_bytes: int) -> Drawing:
    """What is chosen for a filled order, checked to be read over its range.  Raises: as `design_badge`."""
    assert order.range_m is not None
    family = family_named(_family_for(order, payload_bytes))
    lens, layout, spacing = _front(order), lay_out(order), family.name == "spacing"
    if not spacing and order.axes != "x":
        raise DesignError(
            f"the pitch code is carried by one field, and axes {order.axes} has {len(layout.fields_mm)}; take axes x, "
            "or the spacing code"
        )
    levels = SPACING_LEVELS if spacing else PITCH_LEVELS
    grid = choose_grid(layout.fields_mm, payload_bytes) if spacing else bands(layout.fields_mm, BANDS)
    slowest, step = choose_beats(layout, order.range_m[1], lens.pitch_mm, levels)
    check_range(order.range_m, layout, grid, lens.pitch_mm, levels, payload_bytes)
    return Drawing(order, family, lens, layout, grid, slowest, step, levels, payload_bytes)


def _is_silk(order: Order, family: str) -> bool:
    """Whether the fields are smooth.  Raises: DesignError where they cannot be."""
    bends = family == "spacing"
    if order.pattern is None:
        # Turned fields and masks are left as they were: more cells of silk were misread, and a film was inconclusive.
        return bends and order.axes != "hex" and order.front == "lens"
    if order.pattern == "silk" and not bends:
        raise DesignError("silk bends the lines of a spacing code; take that code, or cells")
    return order.pattern == "silk"


def _front(order: Order) -> Lens:
    """The front layer of the order.  Raises: SpecError for a lens that does not exist."""
    thickness_mm, label = order.lens_thickness_mm, str(as_path(order.lens or ""))
    if order.front == "mask":
        return mask_named(label, GAP_MM if thickness_mm is None else thickness_mm)
    lens = lens_named(label)
    return lens if thickness_mm is None else sheet_lens(lens.pitch_mm, thickness_mm, lens.refractive_index)


def _check_dots(order: Order, gratings: tuple[Grating, ...], lens_pitch_mm: float) -> None:
    """The code must survive the printer's dots; a plain vector leaves them to the printer.

    Raises: DesignError with the resolution at which it does.
    """
    worst = 0.0 if order.form == "vector" else _dot_phase_rad(order, gratings, lens_pitch_mm, order.printer_dpi)
    if worst > MAX_DOT_PHASE_RAD:
        enough = next(
            dpi
            for dpi in PRINTER_DPI
            if dpi > order.printer_dpi and _dot_phase_rad(order, gratings, lens_pitch_mm, dpi) <= MAX_DOT_PHASE_RAD
        )
        raise DesignError(
            f"on dots of {order.printer_dpi} dpi a cell's fringe is {worst:.2f} rad off its place, and "
            f"{MAX_DOT_PHASE_RAD:g} rad leave its symbol readable; print at {enough} dpi or more, or in vector form",
            least_dpi=enough,
        )


def _blank_grating(drawing: Drawing, field: int, *, silk: bool) -> Grating:
    """A grating whose cells have their places and roles but no identity yet."""
    (axis, rect), lens_pitch_mm = drawing.layout.fields_mm[field], drawing.lens.pitch_mm
    slowest, step = drawing.slowest_per_mm, drawing.step_per_mm
    wanted = (1.0 - 1.0 / REFERENCE_RATIO) / lens_pitch_mm
    level = min(max(round((wanted - slowest) / step), 0), drawing.levels - 1)
    reference = -(slowest + level * step)
    pitch_mm = float(rear_pitch_for_beat_mm(lens_pitch_mm, reference))
    cells, roles = cells_and_roles(rect, axis, drawing.grid, pitch_mm, field, silk=silk)
    code = Code(
        roles=roles,
        payload_bits=8 * drawing.payload_bytes,
        levels=drawing.levels,
        base_frequency_per_mm=-slowest,
        frequency_step_per_mm=-step,
        reference_level=None if drawing.spacing else level,
        phase_levels=PHASE_LEVELS if drawing.spacing else None,
    )
    return Grating(rect, axis, pitch_mm, drawing.family.name, cells, code)


def _reference_pitch_mm(grating: Grating, cells: tuple[Cell, ...]) -> float:
    assert grating.code is not None
    return float(cells[grating.code.reference_cell].pitch_mm)


def _family_for(order: Order, payload_bytes: int) -> str:
    """The code asked for, or the one that carries a payload of this length; checked to fit."""
    fitting = [name for name, sizes in FAMILY_BYTES.items() if payload_bytes in sizes]
    name = order.code or (fitting[0] if fitting else "spacing")
    allowed = FAMILY_BYTES.get(name, ())
    if allowed and payload_bytes not in allowed:
        digits = " or ".join(str(2 * count) for count in allowed)
        raise CodeError(
            f"a payload of {8 * payload_bytes} bits does not fit; the {name} code carries {digits} hex digits"
        )
    return name


def choose_beats(layout: Layout, far_m: float, lens_pitch_mm: float, levels: int) -> tuple[float, float]:
    """Slowest beat and step of levels that the range's far end resolves and the tolerances cannot push to zero.

    Convention: magnitudes, cycles per mm of page.
    Source: module docstring; camera `DESIGN_FOCAL_PX`.  `_reach_m` says how far it goes.
    """
    width_mm = fringe_length_mm(layout)
    tolerance = PITCH_TOLERANCE / lens_pitch_mm
    slowest = tolerance + MIN_FRINGES / width_mm
    fastest = DESIGN_FOCAL_PX / (1000.0 * far_m) / MIN_PX_PER_FRINGE - tolerance
    return slowest, min((fastest - slowest) / (levels - 1), MAX_STEP_FRINGES / width_mm)


def _check_printer(order: Order, pitch_mm: float) -> None:
    """A line must be drawn some dots wide."""
    drawn_mm = pitch_mm * DUTY - order.ink_growth_um / 1000
    dots = drawn_mm / (MM_PER_INCH / order.printer_dpi)
    if drawn_mm < pitch_mm * DUTY / 4:
        raise DesignError(
            f"an ink growth of {order.ink_growth_um:g} um leaves {1000 * drawn_mm:.0f} um of a line of "
            f"{1000 * pitch_mm * DUTY:.0f} um; use another printer or paper, or take a coarser lens"
        )
    if dots < MIN_DOTS_PER_LINE:
        needed = MIN_DOTS_PER_LINE * MM_PER_INCH / drawn_mm
        least = next((dpi for dpi in PRINTER_DPI if dpi >= needed), math.ceil(needed))
        raise DesignError(
            f"at {order.printer_dpi} dpi a line of {drawn_mm:.3f} mm is {dots:.1f} dots wide, fewer than "
            f"{MIN_DOTS_PER_LINE:g}; print at {least} dpi or more, or take a coarser lens",
            least_dpi=least,
        )


def _dot_phase_rad(order: Order, gratings: tuple[Grating, ...], lens_pitch_mm: float, dpi: int) -> float:
    """The largest shift of a cell's fringe on dots of that resolution."""
    dot_mm = MM_PER_INCH / dpi
    return max(
        abs(realised(grating, cell, lens_pitch_mm, dot_mm, order.ink_growth_um / 1000).phase_error_rad)
        for grating in gratings
        if isinstance(grating.axis, str)
        for cell in grating.cells
    )
