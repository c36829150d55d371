"""The pitch test sheet, the lenticular trade's chart: bands of lines about a lens sheet's nominal pitch.

Seen through the sheet, the band whose lines match the lenses is evenly light or evenly dark.  The further a band is
from the match, the more fringes it shows.  The chart is a Badge without an identity, so it is printed and read as one.

Convention: bands are numbered from 1 at the top; printed lines per inch rise downwards by `STEP_LPI` a band.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from moireid.badge import Badge, Cell, Grating, Lens, Markers, Rect
from moireid.designer.grid import DUTY
from moireid.designer.layout import DICTIONARY, PAPER_MARGIN_MM, QUIET_MODULES
from moireid.designer.order import MARGIN_MM
from moireid.errors import DesignError
from moireid.idcodes.pitch import line_up
from moireid.profiles import CHART_FAMILY, PAPERS_MM, lens_named
from moireid.sheets import MM_PER_INCH

STEP_LPI = 0.1
#: The field is as wide as that of the default badge, so that a sheet cut for that covers it; the labels are next to it.
FIELD_MM = 136.0
#: Wide enough for the labels, and so narrow that crop marks keep clear of the scale bar at the paper's edge.
BOARD_WIDTH_MM = 178.0
MARKER_MM = 26.0
#: From where a chart is read, m.
READ_FROM_M = 1.0
#: Lower bands are too narrow to be separated at 2 m (4 px); in higher ones a twisted sheet blurs the fringes.
MIN_BAND_MM, MAX_BAND_MM = 5.0, 11.0
#: Least dots of a line; a chart may be coarser than a badge, because its phases carry no code.
MIN_DOTS_PER_LINE = 1.5
#: Badges use markers 0 to 3.  Charts of neighbouring pitches use others; only the markers distinguish them.
FIRST_ID, ID_GROUPS = 4, 11


def design_chart(
    lens: str = "50lpi",
    *,
    printer_dpi: int = 1200,
    paper: str = "a4",
    steps: int = 10,
    form: str = "dots",
) -> Badge:
    """Design a pitch test sheet, whose bands show which pitch a lens sheet has.

    Parameters
    ----------
    lens : str
        Label of a lens sheet such as "50lpi", or the path of a lens profile.
    printer_dpi : int
        Dots to the inch of the printer.
    paper : str
        The page, one of `profiles.PAPERS_MM`.
    steps : int
        Bands on each side of the nominal pitch.
    form : str
        Of the printed lines, one of `moireid.profiles.FORMS`.

    Returns
    -------
    Badge
        Without an id.  Its one grating has the nominal pitch and the family `CHART_FAMILY`; its cells are the bands.

    Raises
    ------
    SpecError
        For a lens that is none.
    DesignError
        Where the bands do not fit the paper or the printer's dots; it names what does.

    Notes
    -----
    Convention: bands are numbered from 1 at the top, and printed lines per inch rise downwards.  All bands have a dark
    line centred on the field's middle.
    Source: the lenticular trade's chart; a band's pitch is 25.4 mm / (nominal lines per inch + k `STEP_LPI`).
    """
    sheet = lens_named(lens)
    nominal_lpi = MM_PER_INCH / sheet.pitch_mm
    _check(sheet, printer_dpi, paper, steps)
    page_mm = PAPERS_MM[paper]
    count = 2 * steps + 1
    band_mm = min(_room_mm(paper) / count, MAX_BAND_MM)
    around_mm = _around_mm()
    width, height = BOARD_WIDTH_MM, band_mm * count + 2 * around_mm
    x0, y0 = (page_mm[0] - width) / 2, (page_mm[1] - height) / 2
    board: Rect = (round(x0, 3), round(y0, 3), round(x0 + width, 3), round(y0 + height, 3))
    left, right = round((page_mm[0] - FIELD_MM) / 2, 3), round((page_mm[0] + FIELD_MM) / 2, 3)
    edges = [round(board[1] + around_mm + k * band_mm, 3) for k in range(count + 1)]
    blank = Grating((left, edges[0], right, edges[-1]), "x", sheet.pitch_mm, CHART_FAMILY, ())
    cells = tuple(
        line_up(
            Cell((left, edges[k], right, edges[k + 1]), sheet.pitch_mm, 0.0, DUTY),
            blank,
            MM_PER_INCH / (nominal_lpi + (k - steps) * STEP_LPI),
        )
        for k in range(count)
    )
    return Badge(
        id=None,
        name=f"pitch test {nominal_lpi:.4g} LPI, {count} bands",
        page_mm=page_mm,
        lens=sheet,
        gratings=(replace(blank, cells=cells),),
        markers=_markers(board, nominal_lpi),
        board_mm=board,
        range_m=(READ_FROM_M, READ_FROM_M),
        print={
            "dpi": printer_dpi,
            "paper": paper,
            "form": form,
            "lens": Path(lens).name,
            "step_lpi": STEP_LPI,
        },
    )


def _check(lens: Lens, printer_dpi: int, paper: str, steps: int) -> None:
    """Check that the bands fit the paper, and that a line has enough dots."""
    if paper not in PAPERS_MM:
        raise DesignError(f"paper {paper!r} is not known; choose one of {', '.join(PAPERS_MM)}")
    most = int((_room_mm(paper) / MIN_BAND_MM - 1) // 2)
    if not 1 <= steps <= most:
        raise DesignError(
            f"{steps} steps on each side do not fit {paper} in bands of {MIN_BAND_MM:g} mm; give 1 to {most}",
            most_steps=most,
        )
    dots = lens.pitch_mm * DUTY / (MM_PER_INCH / printer_dpi)
    if dots < MIN_DOTS_PER_LINE:
        raise DesignError(
            f"at {printer_dpi} dpi a line of {lens.pitch_mm * DUTY:.3f} mm is {dots:.1f} dots wide, fewer than "
            f"{MIN_DOTS_PER_LINE:g}; print at 300 dpi or more, or take a coarser lens"
        )


def _around_mm() -> float:
    """From the board's upper edge to the first band: margin, marker, and its white rim."""
    return MARGIN_MM + MARKER_MM + QUIET_MODULES * MARKER_MM / 6


def _room_mm(paper: str) -> float:
    """Height that bands may take on a paper."""
    return PAPERS_MM[paper][1] - 2 * PAPER_MARGIN_MM - 2 * _around_mm()


def _markers(board: Rect, nominal_lpi: float) -> Markers:
    """Four markers in the board's corners; their ids distinguish charts of neighbouring pitches."""
    inset = MARGIN_MM + MARKER_MM / 2
    first = FIRST_ID + 4 * (round(nominal_lpi) % ID_GROUPS)
    low, high = (board[0] + inset, board[2] - inset), (board[1] + inset, board[3] - inset)
    centers = ((low[0], high[0]), (low[1], high[0]), (low[1], high[1]), (low[0], high[1]))
    return Markers(DICTIONARY, MARKER_MM, (first, first + 1, first + 2, first + 3), centers)
