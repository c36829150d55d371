"""A designed badge in figures for people: what is chosen, and why it fits."""

from __future__ import annotations

import math

from moireid.badge import Badge, Lens
from moireid.designer.grid import DUTY
from moireid.designer.layout import explain_fiducial
from moireid.designer.order import DESIGN_FOCAL_PX
from moireid.designer.reach import (
    PROMISED_SHARE,
    RECEIVERS,
    link_budgets,
    read_of,
    verdict_reach_m,
)
from moireid.dots import on_dots
from moireid.errors import SpecError
from moireid.frames import axis_words, own_rect
from moireid.idcodes.spacing import PHASE_LEVELS
from moireid.lenticule import critical_tangent
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
    grating = badge.gratings[0]
    code = grating.code
    if code is None or badge.range_m is None:
        raise SpecError(f"{badge.name!r} carries no code or names no range; give a badge that design_badge made")
    low, _, high, _ = own_rect(grating.axis, grating.rect_mm)
    length_mm = high - low
    middle = grating.cells[code.reference_cell]
    beats = [
        1.0 / badge.lens.pitch_mm - 1.0 / cell.pitch_mm
        for cell, role in zip(grating.cells, code.roles, strict=True)
        if role != "phase"
    ]
    far = DESIGN_FOCAL_PX / (1000.0 * badge.range_m[1])
    dot_mm = find_dot_mm(badge)
    rows = [
        ("identity", f"{badge.id}, {badge.payload_bits} bits, {grating.family} code"),
        _explain_front(badge.lens),
        *_explain_fields(badge),
        ("reference row", f"pitch {middle.pitch_mm:.5f} mm, beat {1 / beats[len(beats) // 2]:.1f} mm"),
        ("slowest and fastest row", f"beat {1 / min(beats):.1f} and {1 / max(beats):.1f} mm"),
        ("level step", f"{abs(code.frequency_step_per_mm) * length_mm:.2f} fringes across {length_mm:g} mm"),
        ("fastest fringe, far end", f"{far / max(beats):.1f} pixels at {badge.range_m[1]:g} m"),
    ]
    phases = [cell for cell, role in zip(grating.cells, code.roles, strict=True) if role == "phase"]
    if phases:
        size = [phases[0].rect_mm[k + 2] - phases[0].rect_mm[k] for k in (0, 1)]
        count = sum(role == "phase" for g in badge.gratings if g.code for role in g.code.roles)
        blend = phases[0].blend_mm
        rows += [
            ("cells", f"{count} of {size[0]:.1f} x {size[1]:.1f} mm, {code.phase_levels} phases each"),
            ("a cell, far end", f"{far * size[0]:.1f} x {far * size[1]:.1f} pixels"),
        ]
        if any(blend):
            rows.append(("lines bend", f"over {blend[0]:.1f} x {blend[1]:.1f} mm from a cell's borders"))
        rows += _explain_reading(badge)
    return [
        *rows,
        explain_fiducial(badge.markers, far),
        ("a line in printer dots", f"{grating.pitch_mm * DUTY / dot_mm:.1f} (each edge placed by itself)"),
        *_explain_dots(badge),
        ("what a forger needs", "see What it takes to pass, in THREATS.md"),
    ]


def _explain_reading(badge: Badge) -> list[tuple[str, str]]:
    """Rows of the table about the distances at which each receiver reads the badge."""
    read, rows = read_of(badge), []
    assert read is not None
    for metres, link in link_budgets(badge):
        chance = f"{link.decode_probability:.4f}" if link.decode_probability < 0.9999 else "above 0.9999"
        figures = f"phase error of a cell {link.phase_error_rad:.2f} rad of {math.pi / PHASE_LEVELS:.2f}"
        rows.append((f"reading all at {metres:g} m", f"probability {chance}, {figures}"))
    share = f"{100 * PROMISED_SHARE:g} of 100 films of 8 s"
    rows += [(f"by {one.words}", f"{share} read up to {read.reach_m(one):.2f} m") for one in RECEIVERS]
    if badge.lens.kind == "lenticular":
        aside = math.degrees(math.atan(critical_tangent(badge.lens)))
        rows.append(("a sheet only laid on", f"moves fringes as a glued one up to {aside:.0f} degrees aside"))
    return [*rows, ("a verdict, swaying 8 s", f"up to {verdict_reach_m(badge):.1f} m; farther, move more")]


def _explain_fields(badge: Badge) -> list[tuple[str, str]]:
    """A row for each field of a badge that senses several directions."""
    if len(badge.gratings) == 1:
        return []
    rows = []
    for grating in badge.gratings:
        low, top, high, bottom = own_rect(grating.axis, grating.rect_mm)
        phases = sum(role == "phase" for role in grating.code.roles) if grating.code else 0
        size = f"{high - low:.1f} mm along its axis, {bottom - top:.1f} mm along its lines, {phases} cells"
        rows.append((f"field along {axis_words(grating.axis)}", size))
    return rows


def _explain_front(lens: Lens) -> tuple[str, str]:
    """The row of the table about the front layer."""
    if lens.kind == "mask":
        share = 100 * (lens.open_fraction or 0.0)
        return "mask", f"pitch {lens.pitch_mm:.4f} mm, {share:g} % open, on {lens.thickness_mm:g} mm of acrylic"
    return "lens", f"pitch {lens.pitch_mm:.4f} mm, {lens.thickness_mm:g} mm thick"


def _explain_dots(badge: Badge) -> list[tuple[str, str]]:
    """Rows of the table about the printer's dots."""
    dots = on_dots(badge)
    if dots is None:
        return []
    by_name = dict(zip(dots["columns"], zip(*dots["cells"], strict=True), strict=True))
    largest = {name: max(abs(value) for value in values) for name, values in by_name.items()}
    uniform = [
        row for row in dots["cells"] if (code := badge.gratings[row[0]].code) is None or code.roles[row[1]] != "phase"
    ]
    beat = max(abs(row[5]) for row in uniform)
    return [
        ("lines on dots", f"edges off by {largest['edge_error_um']:.1f} um at most, no drift"),
        ("a cell on dots", f"fringe off by {largest['phase_error_rad']:.3f} rad at most, of 0.79"),
        ("a uniform row on dots", f"beat off by {100 * beat:.3f} % at most"),
    ]
