"""From an order to a badge that can be made, for `print-your-badge` and for the studio.

`Wear` is the requested size and looks of a badge, and chooses the mount that suits them.  `plan_badge` designs the
badge once and plans its parts once; it writes nothing and asks the registry for holders alone.
`fabrication.print_badge` makes the files of a plan, and calls what enters the badge into a registry before they are in
place.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.errors import FabricationError, RegistryError, SpecError

if TYPE_CHECKING:
    from moireid.artwork.placing import Look
    from moireid.badge import Badge
    from moireid.designer import Request
    from moireid.designer.drawn import HolderOf, KnownHolder
    from moireid.fabrication.mount_parts import Parts
    from moireid.fabrication.process_figures import MountFigures


@dataclass(frozen=True)
class IssueOrder:
    """What a badge is to be.

    request: as `Wear.fit` gives it; mount: None where no mount was named; payload: the identity, None for one that is
    drawn at random.
    """

    request: Request
    wear: Wear
    mount: str | None
    figures: MountFigures
    payload: bytes | None = None


@dataclass(frozen=True)
class IssuePlan:
    """A badge that can be made, and all that goes with it.

    look: None for name, lines and id alone; holder: who has this same badge already; notes: sentences for the person
    who ordered it, on the mount, on what is printed in part, and on the identity.
    """

    badge: Badge
    look: Look | None
    holder: KnownHolder | None
    parts: Parts
    notes: tuple[str, ...]

    @property
    def files(self) -> list[str]:
        """Names of the files that are made; badge.json is the last."""
        from moireid.fabrication.package import file_names

        return file_names(self.parts)


def plan_badge(order: IssueOrder, holder_of: HolderOf | None) -> IssuePlan:
    """Design the badge, plan its parts and check its looks; nothing is written.

    Parameters
    ----------
    holder_of : callable, optional
        As for `drawn_badge`.

    Raises
    ------
    RegistryError
        Where another badge has the identity; else as `drawn_badge`, `check_look` and `Wear.parts`.
    """
    from moireid.artwork.content import with_lines
    from moireid.designer.drawn import drawn_badge
    from moireid.fabrication.page.lettering import name_note
    from moireid.fabrication.page.marks import check_look, look_notes

    drawn = drawn_badge(order.request, order.payload, holder_of)
    badge, look = with_lines(drawn.badge, order.wear.lines), order.wear.look(order.request.axes)
    about_name = name_note(badge.name)
    check_look(badge, look)
    holder = holder_of(badge.id or "") if holder_of else None
    if holder is not None and holder.badge != badge:
        raise RegistryError(
            f"badge {badge.id} is held by {holder.name!r} already, and is another badge; give another identity"
        )
    parts, about_mount = order.wear.parts(badge, order.mount, order.figures)
    notes = (about_mount, about_name, *look_notes(badge, look), drawn.note)
    return IssuePlan(badge, look, holder, parts, tuple(note for note in notes if note))


@dataclass(frozen=True)
class Wear:
    """The options as they were given; None for an option that was not given."""

    format_name: str | None
    orientation: str | None
    size_text: str | None
    lens: str | None
    range_text: str | None
    template: str | None
    lines: tuple[str, ...]
    logo: Path | None
    portrait: Path | None
    colour: str | None
    typeface: str | None = None

    @property
    def files(self) -> list[Path]:
        """The files that were given."""
        named = (Path(text) for text in (self.template, self.lens) if text is not None)
        return [path for path in (self.logo, self.portrait, *named) if path is not None and path.is_file()]

    def fit(self, request: Request, payload_bytes: int | None = None) -> Request:
        """The request in that format or size, with lens and range as given, or else as suit it and its template.

        Parameters: payload_bytes: length of the identity that was given; None for one that is drawn.
        Raises: SpecError for options that contradict each other; DesignError if nothing works.
        """
        from moireid.designer.formats import format_named, in_format, turned, within_reach
        from moireid.designer.request import parse_range_m, parse_size_mm
        from moireid.sheets import DEFAULT_LENS

        if self.size_text is not None and (self.format_name is not None or self.orientation is not None):
            raise SpecError("--size is for a badge of no format; give it without --format and --orientation")
        range_m = parse_range_m(self.range_text) if self.range_text else None
        size_mm = parse_size_mm(self.size_text) if self.size_text else request.size_mm
        if self.format_name is not None or self.orientation is not None:
            size_mm = turned(format_named(self.format_name or "board").size_mm, self.orientation)
        look = self.look(request.axes)
        if look is not None:
            side = look.template.side(*size_mm)
            request = replace(request, frame=replace(request.frame, head=side.head, foot=side.foot))
        if self.format_name is not None or self.orientation is not None:
            name = self.format_name or "board"
            chosen: dict[str, Any] = {"orientation": self.orientation, "lens": self.lens, "range_m": range_m}
            return in_format(request, name, payload_bytes=payload_bytes, **chosen)
        # A mask is of any pitch.
        usual = DEFAULT_LENS if request.front == "lens" else request.lens
        request = replace(request, size_mm=size_mm, lens=self.lens or usual, range_m=range_m or request.range_m)
        # Each of three fields is smaller than one over the whole board.
        smaller = look is not None or request.axes == "hex"
        return within_reach(request, payload_bytes) if smaller and range_m is None else request

    def look(self, axes: str) -> Look | None:
        """Template, pictures and colour of the badge; None for a plain board with only name, lines and id.

        Parameters: axes: of the fringes; three directions take the space of a template, unless one is asked for.
        Raises: SpecError for a template, picture or colour that cannot be used.
        """
        from moireid.artwork.content import Artwork, content_of
        from moireid.artwork.placing import Look
        from moireid.artwork.template import template_named
        from moireid.designer.formats import format_named

        content = content_of(self.logo, self.portrait, self.colour)
        plain = (axes == "hex" or self.format_name in (None, "board")) and content == Artwork()
        if self.template is None and self.typeface is None and plain:
            return None
        own = "webcam" if self.format_name == "webcam" else "plain"
        corner_mm = format_named(self.format_name or "board").corner_mm
        return Look(template_named(self.template or own), content, corner_mm, self.typeface)

    def parts(self, badge: Badge, mount: str | None, figures: MountFigures) -> tuple[Parts, str | None]:
        """The parts of the mount, and a note if a format gets another mount than the one asked for.

        A format whose mount cannot be printed gets the snap-in holder, which fits all formats; if that cannot be made
        either, it gets none.

        Raises
        ------
        FabricationError
            If neither the requested mount nor a holder can be made; or if a figure of the printer was given by name.
        """
        from moireid.designer.formats import format_named
        from moireid.fabrication.mount_parts import plan_parts

        form, kind = self.format_name, mount or "lanyard"
        if kind in ("holder", "none") or form in (None, "board") or "printed" in figures.insisted:
            return plan_parts(badge, kind, figures), None
        wished, refused = None, None
        try:
            wished = plan_parts(badge, kind, figures)
        except FabricationError as error:
            refused = error
        if wished is not None and "printed" not in wished.left_out:
            return wished, None
        with suppress(FabricationError):
            held = plan_parts(badge, "holder", figures)
            if "printed" not in held.left_out:
                return held, f"no printed mount of the kind {kind} fits {form}; a snap-in holder is made instead"
        if wished is not None:
            return wished, None
        if mount is not None and refused is not None:
            raise refused
        note = f"no mount is made for {form}; the badge goes into {format_named(form or kind).words}"
        return plan_parts(badge, "none", figures), note
