"""The choice of beat frequencies and cells, and the Badge.

The slowest beat must keep enough fringes in the grating to be distinguished from shading, even if print scale and lens
pitch are off by their tolerances.  The fastest must keep enough pixels in a fringe at the far end of the range.  The
beat levels divide the interval between the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from moireid.badge import Badge, Cell, Code, Grating, Lens
from moireid.designer.grid import DUTY, Grid, bands, cells_and_roles, choose_grid
from moireid.designer.layout import Layout, lay_out
from moireid.designer.reach import (
    MIN_FRINGES,
    MIN_PX_PER_FRINGE,
    PITCH_TOLERANCE,
    check_range,
    fringe_length_mm,
)
from moireid.designer.request import DESIGN_FOCAL_PX, FAMILY_BYTES, Request, clean_name
from moireid.dots import realised
from moireid.errors import CodeError, DesignError, SpecError
from moireid.idcodes import family_named
from moireid.idcodes.pitch import BANDS
from moireid.idcodes.pitch import LEVELS as PITCH_LEVELS
from moireid.idcodes.spacing import PHASE_LEVELS
from moireid.optics import rear_pitch_for_beat_mm
from moireid.profiles import Printer, lens_named, mask_named, sheet_of_thickness
from moireid.sheets import MM_PER_INCH

#: More spacing of levels than this many fringes across the grating only shortens the fringes.
MAX_STEP_FRINGES = 0.55
#: A printed line narrower than this many dots has no dependable width.
MIN_DOTS_PER_LINE = 3.0
#: A symbol is confused beyond pi / 4; rounding to dots may take this much of it, the rest is for the film.
MAX_DOT_PHASE_RAD = 0.25
#: Resolutions that printers have; beyond 1200 dpi no line of a lens sheet's pitch can be off by so much.
PRINTER_DPI = (300, 360, 400, 600, 720, 1200, 1440, 2400)
#: Beat levels of the spacing family's uniform rows.
SPACING_LEVELS = 8
#: How the lines of neighbouring cells meet.
PATTERNS = ("cells", "silk")
#: The published prototype's printed pitch is 1.0236 lens pitches; the pitch family's reference keeps near that ratio.
REFERENCE_RATIO = 0.52 / 0.508


@dataclass(frozen=True)
class Beats:
    """The chosen beat frequencies, cycles per mm of page, as magnitudes: slowest level and step."""

    slowest_per_mm: float
    step_per_mm: float
    levels: int


def design_badge(request: Request, payload: bytes) -> Badge:
    """Design the badge that carries a payload and can be read over the request's range.

    Parameters
    ----------
    request : Request
        Whose badge, on which sheet and printer, read from how far.
    payload : bytes
        Its identity, 8 or 16 bytes, or 3 of the pitch family.

    Returns
    -------
    Badge
        All that printing, filming and verifying need.

    Raises
    ------
    SpecError
        For a lens or a name that is none.
    DesignError
        Where nothing works; it names what would.
    CodeError
        Where the payload does not fit.

    Notes
    -----
    Convention: printed pitches are coarser than the lens pitch, so beats are negative, as in the published prototype.
    Source: `choose_beats`; p_r = 1 / (1/p_f + f_b).
    """
    name = clean_name(request.name)
    family = family_named(_family_for(request, payload))
    lens, layout, spacing = _front(request), lay_out(request), family.name == "spacing"
    levels, count = SPACING_LEVELS if spacing else PITCH_LEVELS, len(layout.fields_mm)
    silk = _is_silk(request, family.name)
    if not spacing and request.axes != "x":
        raise DesignError(
            f"the pitch code is carried by one field, and axes {request.axes} has {count}; take axes x, or the spacing "
            "code"
        )
    grid = choose_grid(layout, len(payload)) if spacing else bands(layout, BANDS)
    beats = choose_beats(layout, request.range_m[1], lens.pitch_mm, levels)
    check_range(request, layout, grid, lens.pitch_mm, levels, len(payload))
    blank = tuple(
        _blank_grating(family.name, lens.pitch_mm, layout, k, grid, beats, len(payload), silk=silk)
        for k in range(count)
    )
    _check_printer(request, blank[0].pitch_mm)
    gratings = tuple(
        Grating(g.rect_mm, g.axis, _reference_pitch_mm(g, cells), g.family, cells, g.code)
        for g, cells in zip(blank, family.write(payload, blank, lens.pitch_mm), strict=True)
    )
    _check_dots(request, gratings, lens.pitch_mm)
    return Badge(
        id=payload.hex(),
        name=name,
        page_mm=layout.page_mm,
        lens=lens,
        gratings=gratings,
        markers=layout.markers,
        payload_bits=8 * len(payload),
        board_mm=layout.board_mm,
        range_m=request.range_m,
        # Of a lens profile only the file's name: its folder is private.
        print={"dpi": request.printer_dpi, "paper": request.paper, "form": request.form}
        | {"lens": Path(request.lens).name}
        | ({"ink_growth_um": request.ink_growth_um} if request.ink_growth_um else {}),
    )


def _is_silk(request: Request, family: str) -> bool:
    """Whether the fields are smooth.  Raises: DesignError where they cannot be."""
    bends = family == "spacing"
    if request.pattern is None:
        # Turned fields and masks are left as they were: more cells of silk were misread, and a film was inconclusive.
        return bends and request.axes != "hex" and request.front == "lens"
    if request.pattern not in PATTERNS:
        raise DesignError(f"the pattern {request.pattern!r} is not known; choose {' or '.join(PATTERNS)}")
    if request.pattern == "silk" and not bends:
        raise DesignError("silk bends the lines of a spacing code; leave out --code, or take cells")
    return request.pattern == "silk"


def _front(request: Request) -> Lens:
    """The front layer of the request.  Raises: SpecError for one that does not exist."""
    if request.front == "lens":
        lens, thickness_mm = lens_named(request.lens), request.lens_thickness_mm
        return lens if thickness_mm is None else sheet_of_thickness(lens, thickness_mm)
    if request.front != "mask":
        raise SpecError(f"front {request.front!r} is not known; choose lens or mask")
    if request.lens_thickness_mm is not None:
        raise SpecError("a mask has no lenticular sheet; give its thickness as the gap")
    return mask_named(request.lens, request.gap_mm)


def _check_dots(request: Request, gratings: tuple[Grating, ...], lens_pitch_mm: float) -> None:
    """The code must survive the printer's dots; a plain vector leaves them to the printer.

    Raises: DesignError with the resolution at which it does.
    """
    worst = 0.0 if request.form == "vector" else _dot_phase_rad(request, gratings, lens_pitch_mm, request.printer_dpi)
    if worst > MAX_DOT_PHASE_RAD:
        enough = next(
            dpi
            for dpi in PRINTER_DPI
            if dpi > request.printer_dpi and _dot_phase_rad(request, gratings, lens_pitch_mm, dpi) <= MAX_DOT_PHASE_RAD
        )
        raise DesignError(
            f"on dots of {request.printer_dpi} dpi a cell's fringe is {worst:.2f} rad off its place, and "
            f"{MAX_DOT_PHASE_RAD:g} rad leave its symbol readable; print at {enough} dpi or more, or in vector form",
            least_dpi=enough,
        )


def _blank_grating(
    family: str,
    lens_pitch_mm: float,
    layout: Layout,
    field: int,
    grid: Grid,
    beats: Beats,
    payload_bytes: int,
    *,
    silk: bool,
) -> Grating:
    """A grating whose cells have their places and roles but no identity yet."""
    axis, rect = layout.fields_mm[field]
    spacing = family == "spacing"
    wanted = (1.0 - 1.0 / REFERENCE_RATIO) / lens_pitch_mm
    level = min(max(round((wanted - beats.slowest_per_mm) / beats.step_per_mm), 0), beats.levels - 1)
    reference = -(beats.slowest_per_mm + level * beats.step_per_mm)
    pitch_mm = float(rear_pitch_for_beat_mm(lens_pitch_mm, reference))
    cells, roles = cells_and_roles(rect, axis, grid, pitch_mm, field, silk=silk)
    code = Code(
        roles=roles,
        payload_bits=8 * payload_bytes,
        levels=beats.levels,
        base_frequency_per_mm=-beats.slowest_per_mm,
        frequency_step_per_mm=-beats.step_per_mm,
        reference_level=None if spacing else level,
        phase_levels=PHASE_LEVELS if spacing else None,
    )
    return Grating(rect, axis, pitch_mm, family, cells, code)


def _reference_pitch_mm(grating: Grating, cells: tuple[Cell, ...]) -> float:
    assert grating.code is not None
    return float(cells[grating.code.reference_cell].pitch_mm)


def _family_for(request: Request, payload: bytes) -> str:
    """The family asked for, or the one that carries a payload of this length; checked to fit."""
    fitting = [name for name, sizes in FAMILY_BYTES.items() if len(payload) in sizes]
    name = request.family or (fitting[0] if fitting else "spacing")
    allowed = FAMILY_BYTES.get(name, ())
    if allowed and len(payload) not in allowed:
        digits = " or ".join(str(2 * count) for count in allowed)
        raise CodeError(
            f"a payload of {8 * len(payload)} bits does not fit; the {name} code carries {digits} hex digits"
        )
    return name


def choose_beats(layout: Layout, far_m: float, lens_pitch_mm: float, levels: int) -> Beats:
    """Beat frequencies that the range's far end resolves and the tolerances cannot push to zero.

    Convention: magnitudes.  Source: module docstring; camera `DESIGN_FOCAL_PX`.  `_reach_m` says how far it goes.
    """
    width_mm = fringe_length_mm(layout)
    tolerance = PITCH_TOLERANCE / lens_pitch_mm
    slowest = tolerance + MIN_FRINGES / width_mm
    fastest = DESIGN_FOCAL_PX / (1000.0 * far_m) / MIN_PX_PER_FRINGE - tolerance
    return Beats(slowest, min((fastest - slowest) / (levels - 1), MAX_STEP_FRINGES / width_mm), levels)


def _check_printer(request: Request, pitch_mm: float) -> None:
    """A line must be drawn some dots wide."""
    drawn_mm = pitch_mm * DUTY - request.ink_growth_um / 1000
    dots = drawn_mm / Printer(request.printer_dpi).dot_mm
    if drawn_mm < pitch_mm * DUTY / 4:
        raise DesignError(
            f"an ink growth of {request.ink_growth_um:g} um leaves {1000 * drawn_mm:.0f} um of a line of "
            f"{1000 * pitch_mm * DUTY:.0f} um; use another printer or paper, or take a coarser lens"
        )
    if dots < MIN_DOTS_PER_LINE:
        needed = MIN_DOTS_PER_LINE * MM_PER_INCH / drawn_mm
        least = next((dpi for dpi in PRINTER_DPI if dpi >= needed), math.ceil(needed))
        raise DesignError(
            f"at {request.printer_dpi} dpi a line of {drawn_mm:.3f} mm is {dots:.1f} dots wide, fewer than "
            f"{MIN_DOTS_PER_LINE:g}; print at {least} dpi or more, or take a coarser lens",
            least_dpi=least,
        )


def _dot_phase_rad(request: Request, gratings: tuple[Grating, ...], lens_pitch_mm: float, dpi: int) -> float:
    """The largest shift of a cell's fringe on dots of that resolution."""
    dot_mm = Printer(dpi).dot_mm
    return max(
        abs(realised(grating, cell, lens_pitch_mm, dot_mm, request.ink_growth_um / 1000).phase_error_rad)
        for grating in gratings
        if isinstance(grating.axis, str)
        for cell in grating.cells
    )
