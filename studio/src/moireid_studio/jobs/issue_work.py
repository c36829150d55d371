"""The work of a process that makes badges and issues them.  It reads the registry, and no film.

It is a process of its own, so that the server never loads build123d.  Its functions are called through `WORK`, with
the file of the order and with callbacks for progress and results, and write to the present folder.  An order is an
archive that the server wrote: `ORDER` or `PEOPLE`, and the pictures that were made of the visitor's.

A badge is issued together with its files, as by `print-your-badge --registry`.  If a process dies after issuing and
before its archive is ready, the same order again makes it and issues nothing new, if it gives the identities.
"""

from __future__ import annotations

import os
import shutil
import zipfile
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

from moireid.errors import SpecError
from moireid.fabrication.package import print_badge
from moireid.issuing import plan_badge
from moireid.names import line_of
from moireid.registry import Registry, open_registry
from moireid.registry.keys import KEYS_VARIABLE
from moireid.registry.seen import SEEN_VARIABLE
from moireid.sandbox.child import Talk
from moireid_studio.jobs.lists import plan_list
from moireid_studio.jobs.orders import ORDERS
from moireid_studio.jobs.task import ORDER, PACKAGE, PEOPLE, Progress, Send, Task
from moireid_studio.problems import plain
from moireid_studio.store.stored_pictures import unpacked, written


def issue_badge(
    order_file: Path,
    progress: Progress,
    send: Send,
    *,
    registry_url: str,
    keys: str,
    seen: str,
    actor: str,
) -> None:
    """Make one badge's package, and issue the badge; `order_file` holds a `VisitorOrder`.

    Raises: as `plan_badge`, and FabricationError where a file fails its check.
    """
    content, pictures = _opened(order_file, ORDER)
    order, folder, steps = ORDERS.validate_json(content), Path("badge"), count(1)
    with _registry(registry_url, keys, seen, actor) as registry:
        made = plan_badge(order.with_files(pictures), registry.by_id)
        most = len(made.files)
        printed = print_badge(
            made.badge,
            folder,
            parts=made.parts,
            maker="studio",
            before_moving=lambda: registry.enroll(made.badge),
            progress=lambda file: progress(next(steps), most),
        )
    _pack(folder, f"badge-{made.badge.id}")
    send(
        {
            "result": {
                "kind": "badge",
                "id": made.badge.id,
                "name": made.badge.name,
                "files": list(printed.files),
                "already_issued": made.holder is not None,
                "left_out": {shop: plain(why) for shop, why in printed.left_out.items()},
                "mount_mass_g": printed.mount_mass_g,
            }
        }
    )


def issue_event(
    people_file: Path,
    progress: Progress,
    send: Send,
    *,
    order: dict[str, Any],
    registry_url: str,
    keys: str,
    seen: str,
    actor: str,
) -> None:
    """Make the package of an event: sheets, a folder for each person, a summary; and issue all badges.

    Raises: the fault of the first row that has one, and FabricationError where a file fails its check.
    """
    from moireid.fabrication.event import print_event
    from moireid.fabrication.mount_parts import plan_parts

    wanted, folder = ORDERS.validate_python(order), Path("event")
    content, pictures = _opened(people_file, PEOPLE)
    with _registry(registry_url, keys, seen, actor) as registry:
        rows, _ = plan_list(content, wanted, registry, pictures)
        for row in rows:
            if row.fault is not None:
                raise SpecError(row.fault)
        badges = [row.badge for row in rows if row.badge is not None]
        event = print_event(
            badges,
            folder,
            parts=plan_parts(badges[0], wanted.mount or "none"),
            maker="studio",
            before_moving=lambda: registry.enroll_many(badges),
            progress=progress,
        )
    _pack(folder, "event")
    send(
        {
            "result": {
                "kind": "event",
                "people": [{"id": badge.id, "name": badge.name, "line": line_of(badge.print)} for badge in badges],
                "sheets": event.sheets,
                "boards_to_a_sheet": event.boards_to_a_sheet,
                "left_out": {shop: plain(why) for shop, why in event.left_out.items()},
                "mount_mass_g": event.mount_mass_g,
            }
        }
    )


def _opened(order_file: Path, name: str) -> tuple[bytes, dict[str, Path]]:
    """What is ordered, and the files of its pictures by key."""
    with zipfile.ZipFile(order_file) as packed:
        return packed.read(name), written(unpacked(packed), Path("pictures"))


def _registry(url: str, keys: str | None, seen: str | None, actor: str) -> Registry:
    """The registry, with the key from the folder `keys` and what was `seen` of it before, for `actor` to act on.

    They are passed in, because the child works in another folder, and its parent may be older than the registry.
    """
    for variable, given in {KEYS_VARIABLE: keys, SEEN_VARIABLE: seen}.items():
        os.environ.pop(variable, None)
        if given is not None:
            os.environ[variable] = given
    return open_registry(url, create=False, actor=actor)


def _pack(folder: Path, top: str) -> None:
    """Put a folder's files into `PACKAGE` under `top`, and take folder and pictures away."""
    with zipfile.ZipFile(PACKAGE, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            packed.write(path, f"{top}/{path.relative_to(folder).as_posix()}")
    shutil.rmtree(folder)
    shutil.rmtree("pictures")


#: Kinds of work by name, called as those in `work.py`, with the file of an order in the place of a film.
WORK: dict[str, Callable[..., None]] = {"badge": issue_badge, "event": issue_event}


def make(talk: Talk) -> None:
    """Do a task in this process, which then ends."""
    task: Task | None = talk.next()
    if task is None:
        return

    def progress(done: int, of: int | None) -> None:
        talk.send({"progress": [done, of]})

    os.chdir(task.folder)
    WORK[task.kind](Path(task.video), progress, talk.send, **task.arguments)
