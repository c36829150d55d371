"""Making packages in the studio's child processes, so that the server never loads build123d.

The functions are called through `making.WORK`, with the file of the order and with callbacks for progress and results.
They write to the present folder.  A badge is issued together with its files, as by `print-your-badge --registry`.
If a child dies after issuing and before its archive is ready, the same order again makes it and issues nothing new, if
it gives the identities.
"""

from __future__ import annotations

import os
import shutil
import zipfile
from itertools import count
from pathlib import Path
from typing import Any

from moireid.designer.drawn import drawn_badge
from moireid.designer.people import Designed, badges_of, design_people, parse_people
from moireid.errors import SpecError
from moireid.fabrication.page.lettering import name_note
from moireid.idcodes import is_name_derived
from moireid.registry import Registry, open_registry
from moireid.registry.keys import KEYS_VARIABLE, SIGNER_VARIABLE
from moireid.registry.look_alikes import alike_within
from moireid.web.jobs.orders import Order, Wish
from moireid.web.jobs.task import PACKAGE, Progress, Tell

#: An event's badges are made one after the other in one child; a larger one is for the command line.
MOST_AT_AN_EVENT = 300


def issue_badge(
    order_file: Path, progress: Progress, tell: Tell, *, registry_url: str, keys: str, signer: str | None, actor: str
) -> None:
    """Make one badge's package, and issue the badge; `order_file` holds the JSON of an `Order`.

    Raises: as `orders.checked`, and FabricationError where a file fails its check.
    """
    from moireid.fabrication.package import file_names, print_badge
    from moireid.fabrication.parts import plan_parts

    order = Order.model_validate_json(order_file.read_text(encoding="utf-8"))
    folder, steps = Path("badge"), count(1)
    with _registry(registry_url, keys, signer, actor) as registry:
        drawn = drawn_badge(order.request(order.name), order.chosen(), registry.by_id)
        badge, holder = drawn.badge, drawn.holder
        most = len(file_names(plan_parts(badge, order.mount), moving=True))
        printed = print_badge(
            badge,
            folder,
            mount=order.mount,
            maker="studio",
            before_moving=lambda: registry.enroll(badge, told=True),
            progress=lambda file: progress(next(steps), most),
        )
    _pack(folder, f"badge-{badge.id}")
    tell(
        {
            "result": {
                "kind": "badge",
                "id": badge.id,
                "name": badge.name,
                "files": list(printed.files),
                "already_issued": holder is not None,
                "left_out": printed.left_out,
                "mount_mass_g": printed.mount_mass_g,
            }
        }
    )


def issue_event(
    people_csv: Path,
    progress: Progress,
    tell: Tell,
    *,
    wish: dict[str, Any],
    registry_url: str,
    keys: str,
    signer: str | None,
    actor: str,
) -> None:
    """Make the package of an event: sheets, a folder for each person, a summary; and issue all badges.

    Raises: the fault of the first row that has one, and FabricationError where a file fails its check.
    """
    from moireid.fabrication.event import print_event

    wanted, folder = Wish.model_validate(wish), Path("event")
    with _registry(registry_url, keys, signer, actor) as registry:
        people, request = parse_people(people_csv.read_bytes()), wanted.request("Everybody")
        badges = badges_of(design_people(people.people, request, holder_of=registry.by_id, name_note=name_note))
        event = print_event(
            badges,
            folder,
            mount=wanted.mount,
            maker="studio",
            before_moving=lambda: registry.enroll_many(badges, told=True),
            progress=progress,
        )
    _pack(folder, "event")
    tell(
        {
            "result": {
                "kind": "event",
                "people": [{"id": badge.id, "name": badge.name} for badge in badges],
                "sheets": event.sheet_count,
                "boards_to_a_sheet": event.boards_to_a_sheet,
                "left_out": event.left_out,
                "mount_mass_g": event.mount_mass_g,
            }
        }
    )


def _registry(url: str, keys: str, signer: str | None, actor: str) -> Registry:
    """The registry, with the authority's key from the folder `keys`, or by asking the signer; for `actor` to act on.

    They are passed in, because the child works in another folder, and its parent may be older than the registry.
    """
    os.environ[KEYS_VARIABLE] = keys
    os.environ.pop(SIGNER_VARIABLE, None)
    if signer is not None:
        os.environ[SIGNER_VARIABLE] = signer
    return open_registry(url, create=False, actor=actor)


def understood(people_csv: bytes, wish: Wish, registry: Registry) -> tuple[list[dict[str, Any]], str | None]:
    """How a list was understood, row by row: row, name, id (None where there is a fault, or it will be drawn), fault,
    note, line; and what was guessed on reading it, if anything.

    Raises: SpecError where the list as a whole cannot be read, or names too many.
    """
    found = parse_people(people_csv)
    people = found.people
    if len(people) > MOST_AT_AN_EVENT:
        raise SpecError(
            f"the list names {len(people)} people, and {MOST_AT_AN_EVENT} can be issued from a page at once; split it, "
            "or use the command print-your-badge"
        )
    designed = list(design_people(people, wish.request("Everybody"), holder_of=registry.by_id, name_note=name_note))
    names = [one.badge.name for one in designed if one.badge]
    alike = {
        name: [f"{other.name} ({other.id})" for other in found] for name, found in registry.look_alikes(names).items()
    }
    for name, other in alike_within(names):
        alike.setdefault(name, []).append(f"{other}, who is in this list")
    return [_row(one, registry, alike.get(one.badge.name, []) if one.badge else []) for one in designed], found.note


def _row(one: Designed, registry: Registry, alike: list[str]) -> dict[str, Any]:
    """One row of the table: a badge that somebody else holds, or that was revoked, is a fault too.

    An identity that is drawn is drawn anew when the list is issued, so it is not told here.
    """
    row, name, badge, fault = one.person.row, one.person.name, one.badge, str(one.fault) if one.fault else None
    notes = [note for note in (one.note, one.name_note) if note]
    notes += [f"looks like {other}, in other letters or case" for other in alike[:1]]
    holder = registry.by_id(badge.id or "") if badge is not None else None
    if holder is not None and holder.revoked_at is not None:
        fault = f"row {row} ({name[:40]!r}): badge {holder.id} was revoked; give another payload in that row"
    elif holder is not None and holder.badge != badge:
        fault = (
            f"row {row} ({name[:40]!r}): badge {holder.id} is held by {holder.name!r} and is another badge; give "
            "another payload in that row"
        )
    elif holder is not None:
        notes.append(f"issued already on {holder.issued_at[:10]}; its files are made again")
    if badge is not None and is_name_derived(badge):
        notes.append("made from the name, so anybody who knows it can print this badge")
    told = badge.id if badge is not None and one.person.payload and not fault else None
    return {
        "row": row,
        "name": name,
        "line": one.person.line,
        "id": told,
        "fault": fault,
        "note": "; ".join(notes) or None,
    }


def _pack(folder: Path, top: str) -> None:
    """Put a folder's files into `PACKAGE` under `top`, and take the folder away."""
    with zipfile.ZipFile(PACKAGE, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            packed.write(path, f"{top}/{path.relative_to(folder).as_posix()}")
    shutil.rmtree(folder)
