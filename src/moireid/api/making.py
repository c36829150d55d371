"""Design a badge and print it, as `print-your-badge` does."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import fields
from typing import Any

from moireid.api.places import Place, opened
from moireid.arguments import checked
from moireid.artwork.columns import kept_pictures
from moireid.badge import Badge, load_badge
from moireid.designer import Order
from moireid.designer.order import MAX_SCALE_OFF, MountFigure
from moireid.errors import SpecError
from moireid.fabrication.package import PrintResult
from moireid.fabrication.package import print_badge as print_planned
from moireid.files import AnyPath
from moireid.issuing import order_again, plan_badge, plan_package
from moireid.user_settings import nearest


@checked()
def design(name: str, *, registry: Place = None, **wish: Any) -> Badge:
    """Design a badge; nothing is written.

    Parameters
    ----------
    name : str
        Who will wear it.
    registry : Registry or str or Path, optional
        Draw an identity of 64 bits that no one in this registry holds; None for 128 bits, where the badge carries them.
    wish
        What else the badge is to be, as the fields of `moireid.Order`: format="a6", lens="62lpi-27mil", range_m=(0.5,
        1.5), template="newsroom", lines=["Reporter"] and so on.

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
    known = [one.name for one in fields(Order)]
    for what in wish:
        if what not in known:
            raise SpecError(f"an order has no field {what}{nearest(what, known)}; help(moireid.Order) lists them")
    order = Order(name, **{"mount": "none"} | wish)
    with ExitStack() as stack:
        held = None if registry is None else stack.enter_context(opened(registry))
        package = plan_badge(order, held.by_id if held is not None else None)
    for note in package.notes:
        warnings.warn(note, stacklevel=3)
    return package.badge


@checked(measured_scale=(1 - MAX_SCALE_OFF, 1 + MAX_SCALE_OFF))
def print_badge(
    badge: Badge | AnyPath,
    folder: AnyPath,
    *,
    mount: str | None = None,
    mount_mm: Mapping[str, MountFigure] | None = None,
    template: AnyPath | None = None,
    logo: AnyPath | None = None,
    portrait: AnyPath | None = None,
    colour: str | None = None,
    registry: Place = None,
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
    mount : {"lanyard", "clip", "stand", "none"}, optional
        What holds the badge; None for a lanyard, or what fits the badge's format instead.
    mount_mm : mapping of str to float, optional
        Other dimensions of the mount, mm, by name, such as {"card_mm": 0.5}.
    template : str or Path, optional
        Of a badge that was read from its file; one of `design` has its template and pictures.
    logo, portrait : str or Path, optional
        Pictures on the badge, likewise.
    colour : str, optional
        The template's accent colour, as "#134e8c" or "teal".
    registry : Registry or str or Path, optional
        Enter the badge into this registry, together with the files: both happen, or neither.
    measured_scale : (float, float)
        Measured size over true size of an earlier print, along x and y.
    overwrite : bool
        Whether older files may be replaced; a badge.json of another identity becomes badge-<its id>.json.
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
    looks = {"template": template, "logo": logo, "portrait": portrait, "colour": colour}
    order = order_again(own, mount=mount, mount_mm=mount_mm or {}, **looks)
    package = plan_package(own, order)
    for note in package.notes:
        warnings.warn(note, stacklevel=3)
    with ExitStack() as stack:
        held = None if registry is None else stack.enter_context(opened(registry))
        return print_planned(
            package.badge,
            folder,
            parts=package.parts,
            measured_scale=measured_scale,
            overwrite=overwrite,
            kept=[*order.files, *kept_pictures([package.badge])],
            before_moving=None if held is None else lambda: held.enroll(own),
            progress=progress,
        )
