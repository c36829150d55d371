"""From an order to a badge that can be made, for `print-your-badge`, for Python and for the studio.

`plan_badge` designs the badge once and plans its parts once; it writes nothing and asks the registry for holders alone.
`fabrication.print_badge` makes the files of a package, and calls what enters the badge into a registry before they are
in place.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from moireid.artwork.content import Artwork, content_of, with_lines
from moireid.artwork.placing import Look
from moireid.artwork.template import template_named
from moireid.badge import Badge
from moireid.designer.design import design_badge, filled
from moireid.designer.formats import format_named, format_of, size_of
from moireid.designer.order import FAMILY_BYTES, Order, random_payload
from moireid.designer.reach import link_budgets
from moireid.errors import DesignError, FabricationError, RegistryError, SpecError
from moireid.fabrication.mount_parts import Parts, plan_parts
from moireid.fabrication.page.lettering import name_note
from moireid.fabrication.page.marks import check_look, look_notes
from moireid.fabrication.process_figures import mount_figures

if TYPE_CHECKING:
    from moireid.registry import Record

#: Where half of all identities are issued, so many draws fail once in 1e19 times; of 64 bits the first is free.
DRAWS = 64
#: A long identity is taken where at both ends of the range it is read from so many of eight-second films.
LEAST_READ = 0.999
#: Returns the holder of an identity, None where it has none.
HolderOf = Callable[[str], "Record | None"]


@dataclass(frozen=True)
class Package:
    """A badge that can be made, and all that goes with it.

    badge: with its looks; holder: who has this same badge already; notes: sentences for the person
    who ordered it, on the mount, on what is printed in part, and on the identity.
    """

    badge: Badge
    holder: Record | None
    parts: Parts
    notes: tuple[str, ...]

    @property
    def files(self) -> list[str]:
        """Names of the files that are made; badge.json is the last."""
        from moireid.fabrication.package import file_names

        return file_names(self.parts)


def plan_badge(order: Order, holder_of: HolderOf | None = None) -> Package:
    """Design the badge, plan its parts and check its looks; nothing is written.

    Parameters
    ----------
    holder_of : callable, optional
        As for `draw`.

    Raises
    ------
    RegistryError
        Where another badge has the identity; else as `draw` and `plan_package`.
    """
    wanted, _ = fitted(order)
    drawn, note = draw(wanted, holder_of)
    badge = with_lines(drawn, order.lines)
    return plan_package(badge, order, held(badge, holder_of), (note,))


def order_again(badge: Badge, **wish: Any) -> Order:
    """An order for the files of a badge that was designed before.

    Parameters: wish: its looks and its mount, as the fields of `Order`; looks are not in badge.json.
    """
    turned = not all(isinstance(grating.axis, str) for grating in badge.gratings)
    return Order(badge.name, format=format_of(badge.outline_mm), axes="hex" if turned else "x", **wish)


def plan_package(badge: Badge, order: Order, holder: Record | None = None, notes: Iterable[str | None] = ()) -> Package:
    """A badge with the looks and the mount of an order; looks that it has stay where the order names none.

    Raises: SpecError as `check_look`; FabricationError as `choose_parts`, and for a name of which nothing is printed.
    """
    about_name = name_note(badge.name)
    if badge.look is None or (order.template or order.logo or order.portrait or order.colour):
        badge = replace(badge, look=look_of(order))
    check_look(badge)
    parts, about_mount = choose_parts(badge, order)
    said = (about_mount, about_name, *look_notes(badge), *notes)
    return Package(badge, holder, parts, tuple(note for note in said if note))


def fitted(order: Order) -> tuple[Order, Look | None]:
    """The order with all that its format and its template say, and its looks.

    Raises: SpecError for options that contradict each other; DesignError if nothing works.
    """
    look, payload = look_of(order), order.identity
    if look is not None:
        side = look.template.side(*size_of(order))
        order = replace(order, head=side.head, foot=side.foot)
    return filled(order, None if payload is None else len(payload)), look


def look_of(order: Order) -> Look | None:
    """Template, pictures and colour of the badge; None for a plain board with only name, lines and id.

    Three directions of fringes take the space of a template, unless one is asked for.
    Raises: SpecError for a template, picture or colour that cannot be used.
    """
    content = content_of(order.logo, order.portrait, order.colour)
    plain = (order.axes == "hex" or order.format in (None, "board")) and content == Artwork()
    if order.template is None and plain:
        return None
    own = "webcam" if order.format == "webcam" else "plain"
    return Look(template_named(str(order.template or own)), content)


def draw(order: Order, holder_of: HolderOf | None, taken: Collection[str] = ()) -> tuple[Badge, str | None]:
    """The badge of a filled order, and a note where its identity is shorter than wished.

    Parameters: holder_of: without a registry to ask, 128 bits are drawn if board and range carry them, so that no two
        badges anywhere are alike; with one, 64 bits are enough; taken: identities that are not drawn either.
    Raises: as `design_badge`; RegistryError where no identity that was drawn is free.
    """
    if order.identity is not None:
        return design_badge(order, order.identity), None
    sizes, note = FAMILY_BYTES[order.code or "spacing"], None
    if holder_of is None and len(sizes) > 1:
        if (long := _long(order, sizes[1])) is not None:
            return long, None
        note = (
            f"a board of this size does not carry {8 * sizes[1]} bits over this range, so one of {8 * sizes[0]} bits "
            "was drawn; a registry (registry) makes sure that no one else holds it"
        )
    for _ in range(DRAWS):
        payload = random_payload(sizes[0])
        if payload.hex() not in taken and (holder_of is None or holder_of(payload.hex()) is None):
            return design_badge(order, payload), note
    raise RegistryError(
        f"{DRAWS} identities of {8 * sizes[0]} bits were drawn, and all are issued already; use the spacing code"
    )


def _long(order: Order, size_bytes: int) -> Badge | None:
    """A badge of a long identity, None where board and range do not carry one."""
    try:
        badge = design_badge(order, random_payload(size_bytes))
    except DesignError:
        # If a short identity does not help either, its own design raises the error.
        return None
    return badge if all(link.decode_probability >= LEAST_READ for _, link in link_budgets(badge)) else None


def held(badge: Badge, holder_of: HolderOf | None) -> Record | None:
    """The holder of this very badge.  Raises: RegistryError where its identity was revoked, or is another badge's."""
    holder = holder_of(badge.id or "") if holder_of else None
    if holder is not None and holder.revoked_at is not None:
        raise RegistryError(
            f"badge {badge.id} of {holder.name!r} was revoked ({holder.revoked_reason}); give another identity"
        )
    if holder is not None and holder.badge != badge:
        raise RegistryError(
            f"badge {badge.id} is held by {holder.name!r} already, and is another badge; give another identity"
        )
    return holder


def choose_parts(badge: Badge, order: Order) -> tuple[Parts, str | None]:
    """The parts of an order's mount, and a note if a format gets another mount than the one asked for.

    A format for which no mount can be made gets none, unless one was asked for.

    Raises
    ------
    SpecError
        For figures without a mount, or of an unknown name.
    FabricationError
        If the requested mount cannot be made; or if a figure of the printer was given by name.
    """
    form, kind, figures = order.format, order.mount or "lanyard", mount_figures(order.mount_mm)
    # Without a mount, an adhesive holds page and sheet together.
    if kind == "none" and any(not name.startswith("adhesive_mm") for name in order.mount_mm):
        raise SpecError(
            "mount_mm= is of a mount; give mount=lanyard, clip or stand with it, or leave it out (adhesive_mm alone "
            "goes without a mount)"
        )
    if kind == "none" or form in (None, "board") or "printed" in figures.insisted:
        return plan_parts(badge, kind, figures), None
    try:
        return plan_parts(badge, kind, figures), None
    except FabricationError:
        if order.mount is not None:
            raise
    note = f"no mount is made for {form}; the badge goes into {format_named(form).words}"
    return plan_parts(badge, "none", figures), note
