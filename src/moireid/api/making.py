"""Design a badge and print it, as `print-your-badge` does."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack

from moireid.api.places import Place, opened
from moireid.badge import Badge, load_badge
from moireid.designer import Request, payload_from_hex
from moireid.designer.formats import format_of
from moireid.designer.request import clean_name
from moireid.errors import SpecError
from moireid.fabrication.package import PrintResult
from moireid.fabrication.package import print_badge as print_planned
from moireid.fabrication.page.marks import check_look, look_notes
from moireid.fabrication.process_figures import MountFigures, mount_figures
from moireid.files import AnyPath, as_path
from moireid.issuing import IssueOrder, Wear, plan_badge


def design(
    name: str,
    *,
    format: str | None = None,
    orientation: str | None = None,
    size_mm: tuple[float, float] | None = None,
    lens: AnyPath | None = None,
    lens_thickness_mm: float | None = None,
    range_m: tuple[float, float] | None = None,
    template: AnyPath | None = None,
    lines: Sequence[str] = (),
    payload: str | bytes | None = None,
    registry: Place = None,
    printer_dpi: int = Request.printer_dpi,
    ink_growth_um: float = Request.ink_growth_um,
    paper: str = Request.paper,
    axes: str = Request.axes,
    front: str = Request.front,
    markers: str = Request.markers,
    pattern: str | None = Request.pattern,
    code: str = "spacing",
    form: str = Request.form,
    gap_mm: float | None = None,
) -> Badge:
    """Design a badge; nothing is written.

    Parameters
    ----------
    name : str
        Who will wear it.
    format : str, optional
        A size for which holders are sold: "cr80", "a7", "4x3in", "a6", "a5", "webcam" or "board", with a sheet and a
        range that suit it; None for a board.
    orientation : {"landscape", "portrait"}, optional
        Whether it is wide or high; None for what is usual for the format.
    size_mm : (float, float), optional
        Width and height, mm, for a badge of no format.
    lens : str or Path, optional
        A label such as "62lpi-27mil", or the file of a lens profile; None for what suits the format.
    lens_thickness_mm : float, optional
        Thickness of the sheet by a calliper, mm; None for that of its label.
    range_m : (float, float), optional
        Nearest and farthest camera, m; None for as far as it can be read.
    template : str or Path, optional
        Where name, lines and pictures go, by name or file; `print_badge` takes it too.
    lines : sequence of str
        Lines below the name.
    payload : str or bytes, optional
        The identity, in hex digits or as bytes; None for one that is drawn at random.
    registry : Registry or str or Path, optional
        Draw an identity of 64 bits that no one in this registry holds; None for 128 bits, where the badge carries them.
    printer_dpi : int
        Dots to the inch of the printer.
    ink_growth_um : float
        By how much the printer widens lines, micrometres.
    paper : {"a4", "letter"}
        The page.
    axes : {"x", "xy", "hex"}
        Directions of motion that the fringes sense.
    front : {"lens", "mask"}
        What is on top of the print.
    markers : {"squares", "frame"}
        What a film finds the badge by.
    pattern : {"silk", "cells"}, optional
        Whether lines bend from cell to cell; None for what suits the badge.
    code : {"spacing", "pitch"}
        How lines carry the identity: by their places, or by their pitch.
    form : {"dots", "vector"}
        How lines are drawn: on the printer's grid, or free of it.
    gap_mm : float, optional
        Thickness of a mask's spacer, mm.

    Returns
    -------
    Badge
        Of a random identity, if none was given: keep it (`print_badge` writes it as badge.json).

    Raises
    ------
    DesignError
        Where no badge can do what is asked; the message names what can be done.
    SpecError
        For wishes that are impossible, or contradict each other.
    RegistryError
        Where someone else holds the identity.

    Warns
    -----
    UserWarning
        On what is not as one may expect, such as letters that no font here has.

    Notes
    -----
    Convention: lengths in mm of the page, distances in m.
    Source: `moireid.issuing.plan_badge`, as the command uses it.
    """
    if gap_mm is not None and front != "mask":
        raise SpecError("gap_mm is the spacer of a mask; give front='mask' with it, or leave it out")
    request = Request(
        clean_name(name),
        printer_dpi=printer_dpi,
        ink_growth_um=ink_growth_um,
        paper=paper,
        axes=axes,
        front=front,
        markers=markers,
        pattern=pattern,
        lens_thickness_mm=lens_thickness_mm,
        family=code,
        form=form,
        gap_mm=Request.gap_mm if gap_mm is None else gap_mm,
    )
    wear = Wear(
        format,
        orientation,
        _words(size_mm, "x", "size_mm"),
        None if lens is None else str(as_path(lens)),
        _words(range_m, "-", "range_m"),
        None if template is None else str(as_path(template)),
        tuple(lines),
        None,
        None,
        None,
    )
    chosen = payload_from_hex(payload, family=code) if isinstance(payload, str) else payload
    request = wear.fit(request, payload_bytes=None if chosen is None else len(chosen))
    order = IssueOrder(request, wear, "none", MountFigures(), chosen)
    with ExitStack() as stack:
        held = None if registry is None else stack.enter_context(opened(registry))
        plan = plan_badge(order, held.by_id if held is not None else None)
    for note in plan.notes:
        warnings.warn(note, stacklevel=2)
    return plan.badge


def _words(pair: tuple[float, float] | None, between: str, what: str) -> str | None:
    """Two numbers as the command's option has them.  Raises: SpecError for what is no pair."""
    if pair is None:
        return None
    try:
        first, second = (float(one) for one in pair)
    except (TypeError, ValueError) as error:
        raise SpecError(f"{what}={pair!r:.60} is no pair of numbers; give two, such as (0.8, 2.5)") from error
    return f"{first}{between}{second}"


def print_badge(
    badge: Badge | AnyPath,
    folder: AnyPath,
    *,
    mount: str | None = None,
    mount_mm: Mapping[str, float] | None = None,
    template: AnyPath | None = None,
    logo: AnyPath | None = None,
    portrait: AnyPath | None = None,
    colour: str | None = None,
    typeface: str | None = None,
    registry: Place = None,
    expires: str | None = None,
    measured_scale: tuple[float, float] = (1.0, 1.0),
    overwrite: bool = False,
    progress: Callable[[str], None] | None = None,
) -> PrintResult:
    """Write all that a person needs to build a badge: the page, how to assemble it, previews, a mount, badge.json.

    Parameters
    ----------
    badge : Badge or str or Path
        The badge, or its badge.json.
    folder : str or Path
        Made where it is absent.
    mount : {"lanyard", "clip", "stand", "holder", "none"}, optional
        What holds the badge; None for a lanyard, or what fits the badge's format instead.
    mount_mm : mapping of str to float, optional
        Other dimensions of the mount, mm, by name, such as {"card_mm": 0.5}.
    template : str or Path, optional
        As it was given to `design`.
    logo, portrait : str or Path, optional
        Pictures on the badge.
    colour : str, optional
        The template's accent colour, as "#134e8c" or "teal".
    typeface : {"sans", "serif", "slab"}, optional
        Of name, lines and identity; None for that of the template.
    registry : Registry or str or Path, optional
        Enter the badge into this registry, together with the files: both happen, or neither.
    expires : str, optional
        The last day on which it counts there, such as "2027-05-03".
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.
    overwrite : bool
        Whether older files may be replaced.
    progress : callable, optional
        Called with the name of the next file.

    Returns
    -------
    PrintResult
        The files by name, and the mount's figures.

    Raises
    ------
    SpecError
        Where a file exists or cannot be written, or the artwork has no room on this badge.
    FabricationError
        Where a file fails its check, or no mount fits.
    RegistryError
        Where the registry holds another badge of this identity.
    MissingExtraError
        Where a mount is asked for and the CAD packages are not installed.

    Warns
    -----
    UserWarning
        On the mount that is made, and on what is not printed.
    """
    own = badge if isinstance(badge, Badge) else load_badge(badge)
    if expires is not None and registry is None:
        raise SpecError("expires is kept by a registry; give registry with it, or leave it out")
    template = None if template is None else str(as_path(template))
    pictures = [None if one is None else as_path(one) for one in (logo, portrait)]
    form = format_of(own.outline_mm)
    wear = Wear(form, None, None, None, None, template, (), pictures[0], pictures[1], colour, typeface)
    look = wear.look("x" if all(isinstance(grating.axis, str) for grating in own.gratings) else "hex")
    check_look(own, look)
    parts, about_mount = wear.parts(own, mount, mount_figures(f"{key}={mm}" for key, mm in (mount_mm or {}).items()))
    for note in filter(None, (about_mount, *look_notes(own, look))):
        warnings.warn(note, stacklevel=2)
    with ExitStack() as stack:
        held = None if registry is None else stack.enter_context(opened(registry))
        return print_planned(
            own,
            folder,
            parts=parts,
            look=look,
            measured_scale=measured_scale,
            overwrite=overwrite,
            kept=[one for one in (*wear.files, None if isinstance(badge, Badge) else badge) if one is not None],
            before_moving=None if held is None else lambda: held.enroll(own, expires=expires),
            progress=progress,
        )
