"""A designed badge in figures for people: what is chosen, and why it fits."""

from __future__ import annotations

import math

from moireid.badge import Badge, CodedFrame
from moireid.designer.grid import DUTY
from moireid.designer.order import DESIGN_FOCAL_PX
from moireid.designer.reach import PROMISED_SHARE, RECEIVERS, link_budgets, read_of, verdict_reach_m
from moireid.dots import on_dots
from moireid.errors import SpecError
from moireid.idcodes.spacing import PHASE_LEVELS
from moireid.profiles import find_dot_mm


def explain(badge: Badge) -> list[tuple[str, str]]:
    """Explain a badge's design in figures.

    Parameters
    ----------
    badge : Badge
        As `design_badge` made it.

    Returns
    -------
    list of (str, str)
        Rows of a table: what, and the figure with its unit.

    Raises
    ------
    SpecError
        For a badge that carries no code or names no range, such as a pitch test sheet.

    Notes
    -----
    Convention: beats are shown as signed periods, mm; negative where the printed pitch is the coarser one.
    Source: `moireid.designer.reach.link_budgets` for the chance of reading, which is estimated.
    """
    grating, lens = badge.gratings[0], badge.lens
    code = grating.code
    if code is None or badge.range_m is None:
        raise SpecError(f"{badge.name!r} carries no code or names no range; give a badge that design_badge made")
    middle = grating.cells[code.reference_cell]
    uniform = [cell for cell, role in zip(grating.cells, code.roles, strict=True) if role != "phase"]
    fastest_per_mm = max(1.0 / lens.pitch_mm - 1.0 / cell.pitch_mm for cell in uniform)
    far = DESIGN_FOCAL_PX / (1000.0 * badge.range_m[1])
    front = f"pitch {lens.pitch_mm:.4f} mm, {lens.thickness_mm:g} mm thick"
    if lens.kind == "mask":
        share = 100 * (lens.open_fraction or 0.0)
        front = f"pitch {lens.pitch_mm:.4f} mm, {share:g} % open, on {lens.thickness_mm:g} mm of acrylic"
    beat_mm = 1 / (1.0 / lens.pitch_mm - 1.0 / middle.pitch_mm)
    marks = badge.markers
    mark, mark_mm = ("frame's line", marks.line_mm) if isinstance(marks, CodedFrame) else ("marker", marks.size_mm)
    rows = [
        ("identity", f"{badge.id}, {badge.payload_bits} bits, {grating.family} code"),
        ("mask" if lens.kind == "mask" else "lens", front),
        ("reference row", f"pitch {middle.pitch_mm:.5f} mm, beat {beat_mm:.1f} mm"),
        ("fastest fringe, far end", f"{far / fastest_per_mm:.1f} pixels at {badge.range_m[1]:g} m"),
        *_explain_reading(badge, far),
        (f"{mark}, far end", f"{far * mark_mm:.1f} pixels of {mark_mm:g} mm"),
        ("a line in printer dots", f"{grating.pitch_mm * DUTY / find_dot_mm(badge):.1f} (each edge placed by itself)"),
    ]
    if (dots := on_dots(badge)) is not None:
        place = dots["columns"].index("phase_error_rad")
        most_rad = max(abs(cell[place]) for cell in dots["cells"])
        rows.append(("a cell on dots", f"fringe off by {most_rad:.3f} rad at most, of {math.pi / PHASE_LEVELS:.2f}"))
    return rows


def _explain_reading(badge: Badge, far_px_per_mm: float) -> list[tuple[str, str]]:
    """Rows about the cells and the distances at which each receiver reads them; none without cells of a code."""
    if (read := read_of(badge)) is None:
        return []
    count = sum(role == "phase" for one in badge.gratings if one.code for role in one.code.roles)
    rows = [
        ("cells", f"{count}, their least side {read.cell_mm:.1f} mm, {PHASE_LEVELS} phases each"),
        ("a cell, far end", f"{far_px_per_mm * read.cell_mm:.1f} pixels"),
    ]
    for metres, link in link_budgets(badge):
        chance = f"{link.decode_probability:.4f}" if link.decode_probability < 0.9999 else "above 0.9999"
        figures = f"phase error of a cell {link.phase_error_rad:.2f} rad of {math.pi / PHASE_LEVELS:.2f}"
        rows.append((f"reading all at {metres:g} m", f"probability {chance}, {figures}"))
    share = f"{100 * PROMISED_SHARE:g} of 100 films of 8 s"
    rows += [(f"by {one.words}", f"{share} read up to {read.reach_m(one):.2f} m") for one in RECEIVERS]
    return [*rows, ("a verdict, swaying 8 s", f"up to {verdict_reach_m(badge):.1f} m; farther, move more")]
