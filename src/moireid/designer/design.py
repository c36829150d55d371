"""The choice of beat frequencies, and the Badge.

The slowest beat must keep enough fringes in the grating to be told from shading even if print scale and lens pitch
are off by their tolerances; the fastest must keep enough pixels in a fringe at the far end of the range.  Sixteen
symbols share what lies between.
"""

from __future__ import annotations

from dataclasses import dataclass

from moireid.badge import Badge, Cell, Code, Grating
from moireid.designer.layout import Layout, lay_out
from moireid.designer.request import Request, clean_name
from moireid.errors import CodeError, DesignError
from moireid.idcodes.pitch import BANDS, LEVELS, PitchFamily
from moireid.idcodes.words import PAYLOAD_BYTES
from moireid.optics import rear_pitch_for_beat_mm
from moireid.profiles import MM_PER_INCH, Printer, lens_named

#: The camera that a design must suffice for: 1080p with the angle of view of a phone's main camera.
DESIGN_FOCAL_PX = 1450.0
DESIGN_IMAGE_PX = (1920, 1080)
#: Print scale may be off by 0.5 % and lens pitch by 0.3 %; both shift every beat by that share of 1/p_f.
PITCH_TOLERANCE = 0.008
#: Fewest fringes across the grating that fit and shading share without confusion, and pixels that a fringe needs.
MIN_FRINGES = 2.0
MIN_PX_PER_FRINGE = 5.0
#: Least and most spacing of symbols, in fringes across the grating.  At 0.4 a symbol's half step is a fifth of a
#: fringe; more than 0.55 only shortens the fringes.
MIN_STEP_FRINGES = 0.40
MAX_STEP_FRINGES = 0.55
MIN_BAND_PX = 4.0
MIN_MARKER_PX = 14.0
#: A printed line narrower than this many dots has no dependable width.
MIN_DOTS_PER_LINE = 3.0
DUTY = 0.5
#: The published prototype's printed pitch is 1.0236 lens pitches; the reference band keeps its ratio where it can.
REFERENCE_RATIO = 0.52 / 0.508


@dataclass(frozen=True)
class Beats:
    """The chosen beat frequencies, cycles per mm of page, as magnitudes: slowest symbol, step, and reference."""

    slowest_per_mm: float
    step_per_mm: float
    reference_level: int


def design_badge(request: Request, payload: bytes) -> Badge:
    """The badge that carries `payload` and can be read over the request's range.

    Convention: printed pitches are coarser than the lens pitch, so beats are negative, as in the published prototype.
    Source: `choose_beats`; p_r = 1 / (1/p_f + f_b).
    Raises: SpecError for a lens or a name that is none; DesignError, which names what would work, where nothing does;
        CodeError where the payload does not fit.
    """
    name = clean_name(request.name)
    if len(payload) != PAYLOAD_BYTES:
        raise CodeError(f"a payload of {len(payload)} bytes does not fit; the pitch code carries {PAYLOAD_BYTES}")
    lens = lens_named(request.lens)
    layout = lay_out(request)
    beats = choose_beats(request, layout, lens.pitch_mm)
    reference = -(beats.slowest_per_mm + beats.reference_level * beats.step_per_mm)
    reference_pitch_mm = float(rear_pitch_for_beat_mm(lens.pitch_mm, reference))
    _check_printer(request, reference_pitch_mm)
    code = Code(
        reference_cell=BANDS // 2,
        frequency_step_per_mm=-beats.step_per_mm,
        levels=LEVELS,
        base_frequency_per_mm=reference,
        first_level=-beats.reference_level,
    )
    family = PitchFamily()
    blank = tuple(Cell(rect, reference_pitch_mm, 0.0, DUTY) for rect in layout.bands_mm)
    grating = Grating(layout.grating_mm, "x", reference_pitch_mm, family.name, blank, code)
    cells = family.write(payload, grating, lens.pitch_mm)
    return Badge(
        id=payload.hex(),
        name=name,
        page_mm=layout.page_mm,
        lens=lens,
        gratings=(Grating(grating.rect_mm, "x", reference_pitch_mm, family.name, cells, code),),
        markers=layout.markers,
        payload_bits=family.payload_bits(grating),
        board_mm=layout.board_mm,
        range_m=request.range_m,
        print={"dpi": request.printer_dpi, "paper": request.paper, "form": "vector", "lens": request.lens},
    )


def choose_beats(request: Request, layout: Layout, lens_pitch_mm: float) -> Beats:
    """Beat frequencies that the range's far end resolves and the tolerances cannot push to zero.

    Convention: magnitudes.  Source: module docstring; camera `DESIGN_FOCAL_PX`.
    Raises: DesignError that names a range or a size that would work.
    """
    width_mm = layout.grating_mm[2] - layout.grating_mm[0]
    far_mm = 1000.0 * request.range_m[1]
    px_per_mm = DESIGN_FOCAL_PX / far_mm
    _check_sight(request, layout, px_per_mm)
    tolerance = PITCH_TOLERANCE / lens_pitch_mm
    slowest = tolerance + MIN_FRINGES / width_mm
    fastest = px_per_mm / MIN_PX_PER_FRINGE - tolerance
    step = (fastest - slowest) / (LEVELS - 1)
    if step * width_mm < MIN_STEP_FRINGES:
        needed = slowest + (LEVELS - 1) * MIN_STEP_FRINGES / width_mm + tolerance
        reach_m = DESIGN_FOCAL_PX / (needed * MIN_PX_PER_FRINGE) / 1000.0
        raise DesignError(
            f"at {request.range_m[1]:g} m a grating of {width_mm:.0f} mm has no room for {LEVELS} beat frequencies; "
            f"end the range at {_below(reach_m)} m or give a wider board",
            reach_m=reach_m,
        )
    step = min(step, MAX_STEP_FRINGES / width_mm)
    wanted = (1.0 - 1.0 / REFERENCE_RATIO) / lens_pitch_mm
    reference_level = min(max(round((wanted - slowest) / step), 0), LEVELS - 1)
    return Beats(slowest, step, reference_level)


def _check_sight(request: Request, layout: Layout, px_per_mm: float) -> None:
    """Markers and bands must be seen at the far end, the whole board at the near end."""
    band_mm = layout.bands_mm[0][3] - layout.bands_mm[0][1]
    for what, size_mm, least in (("marker", layout.markers.size_mm, MIN_MARKER_PX), ("band", band_mm, MIN_BAND_PX)):
        if size_mm * px_per_mm < least:
            reach_m = DESIGN_FOCAL_PX * size_mm / least / 1000.0
            raise DesignError(
                f"at {request.range_m[1]:g} m a {what} of {size_mm:.1f} mm is {size_mm * px_per_mm:.1f} pixels, fewer "
                f"than the {least:g} it needs; end the range at {_below(reach_m)} m or give a larger board",
                reach_m=reach_m,
            )
    board = (layout.board_mm[2] - layout.board_mm[0], layout.board_mm[3] - layout.board_mm[1])
    near_m = max(side * DESIGN_FOCAL_PX / image for side, image in zip(board, DESIGN_IMAGE_PX, strict=True)) / 1000.0
    if request.range_m[0] < near_m:
        raise DesignError(
            f"at {request.range_m[0]:g} m a board of {board[0]:g} x {board[1]:g} mm overfills the picture; "
            f"begin the range at {near_m + 0.005:.2f} m or give a smaller board",
            near_m=near_m,
        )


def _check_printer(request: Request, pitch_mm: float) -> None:
    """A printed line must be some dots wide."""
    dots = pitch_mm * DUTY / Printer(request.printer_dpi).dot_mm
    if dots < MIN_DOTS_PER_LINE:
        least = int(MIN_DOTS_PER_LINE * MM_PER_INCH / (pitch_mm * DUTY)) + 1
        raise DesignError(
            f"at {request.printer_dpi} dpi a line of {pitch_mm * DUTY:.3f} mm is {dots:.1f} dots wide, fewer than "
            f"{MIN_DOTS_PER_LINE:g}; print at {least} dpi or more, or take a coarser lens",
            least_dpi=least,
        )


def _below(metres: float) -> str:
    """A distance rounded down to centimetres, so that the advice itself works."""
    return f"{int(metres * 100) / 100:.2f}"


def explain(badge: Badge) -> list[tuple[str, str]]:
    """Why the badge is as it is: rows of (what, figure with unit) for a table."""
    grating = badge.gratings[0]
    assert grating.code is not None and badge.range_m is not None
    width_mm = grating.rect_mm[2] - grating.rect_mm[0]
    band_mm = grating.cells[0].rect_mm[3] - grating.cells[0].rect_mm[1]
    beats = [1.0 / badge.lens.pitch_mm - 1.0 / cell.pitch_mm for cell in grating.cells]
    far_px_per_mm = DESIGN_FOCAL_PX / (1000.0 * badge.range_m[1])
    dot_mm = Printer(int((badge.print or {}).get("dpi", 1200))).dot_mm
    return [
        ("identity", f"{badge.id}, {badge.payload_bits} bits"),
        ("lens", f"pitch {badge.lens.pitch_mm:.4f} mm, {badge.lens.thickness_mm:g} mm thick"),
        ("reference band", f"pitch {grating.pitch_mm:.5f} mm, beat {1 / beats[grating.code.reference_cell]:.1f} mm"),
        ("slowest and fastest band", f"beat {1 / min(beats):.1f} and {1 / max(beats):.1f} mm"),
        ("symbol step", f"{abs(grating.code.frequency_step_per_mm) * width_mm:.2f} fringes across {width_mm:g} mm"),
        ("fastest fringe, far end", f"{far_px_per_mm / max(beats):.1f} pixels at {badge.range_m[1]:g} m"),
        ("band height, far end", f"{far_px_per_mm * band_mm:.1f} pixels of {band_mm:g} mm"),
        ("marker, far end", f"{far_px_per_mm * badge.markers.size_mm:.1f} pixels of {badge.markers.size_mm:g} mm"),
        ("a line in printer dots", f"{grating.pitch_mm * DUTY / dot_mm:.1f} (edges placed absolutely, in vectors)"),
    ]  # fmt: skip
