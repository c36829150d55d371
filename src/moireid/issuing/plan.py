"""What is made for one person, planned first and then written.

`plan_badge` designs the badge once and plans its parts once; it writes nothing and asks the registry for holders alone.
`write` makes the files of a plan and issues the badge together with them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.errors import RegistryError

if TYPE_CHECKING:
    from moireid.artwork.placing import Look
    from moireid.badge import Badge
    from moireid.designer import Request
    from moireid.designer.drawn import HolderOf, KnownHolder
    from moireid.fabrication.assembly.assembly_words import Maker
    from moireid.fabrication.package import PrintResult
    from moireid.fabrication.parts import Parts
    from moireid.fabrication.process_figures import MountFigures
    from moireid.issuing.wear import Wear


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
    mount: str
    parts: Parts
    notes: tuple[str, ...]

    @property
    def files(self) -> list[str]:
        """Names of the files that `write` makes; badge.json is the last."""
        from moireid.fabrication.package import file_names

        return file_names(self.parts, moving=True)


def plan_badge(order: IssueOrder, holder_of: HolderOf | None) -> IssuePlan:
    """Design the badge, plan its parts and check its looks; nothing is written.

    Parameters: holder_of: as for `drawn_badge`.
    Raises: as `drawn_badge`, `check_look` and `Wear.parts`; RegistryError where another badge has the identity.
    """
    from moireid.artwork.content import with_lines
    from moireid.designer.drawn import drawn_badge
    from moireid.fabrication.page.dress import check_look, look_notes
    from moireid.fabrication.page.lettering import name_note

    drawn = drawn_badge(order.request, order.payload, holder_of)
    badge, look = with_lines(drawn.badge, order.wear.lines), order.wear.look(order.request.axes)
    about_name = name_note(badge.name)
    check_look(badge, look)
    holder = holder_of(badge.id or "") if holder_of else None
    if holder is not None and holder.badge != badge:
        raise RegistryError(
            f"badge {badge.id} is held by {holder.name!r} already, and is another badge; give another identity"
        )
    mount, parts, about_mount = order.wear.parts(badge, order.mount, order.figures)
    notes = (about_mount, about_name, *look_notes(badge, look), drawn.note)
    return IssuePlan(badge, look, holder, mount, parts, tuple(note for note in notes if note))


def write(
    plan: IssuePlan,
    folder: Path,
    *,
    measured_scale: tuple[float, float] = (1.0, 1.0),
    overwrite: bool = False,
    maker: Maker = "command",
    kept: Sequence[Path] = (),
    issue: Callable[[], object] | None = None,
    progress: Callable[[str], None] | None = None,
) -> PrintResult:
    """Make the files of a plan, whole or not at all.

    Parameters: issue: enters the badge into a registry; it is called when all files are made and none is in place yet;
        the others: as for `print_badge`.
    Raises: as `print_badge`.
    """
    from moireid.fabrication.package import print_badge

    return print_badge(
        plan.badge,
        folder,
        mount=plan.mount,
        parts=plan.parts,
        measured_scale=measured_scale,
        look=plan.look,
        overwrite=overwrite,
        maker=maker,
        kept=kept,
        before_moving=issue,
        progress=progress,
    )
