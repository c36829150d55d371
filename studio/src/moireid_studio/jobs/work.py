"""The work of a film's own process: a film in, a verdict out.  Nothing here knows of requests, pages or registries.

Loading this module loads all packages of the work.  A process that has loaded it is forked for each job, so that the
job can begin at once (`child.py`).

A piece of work as it is given to its own process.

The server loads this file and not `work.py`, because it does not need the packages of the work itself.

What the process of a film that is to be identified may ask of the registry, and the server's own word in its result.

The process may be in a stranger's hands.  It gets an answer to these two questions, and never the registry.
"""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import av  # noqa: F401 - loaded ahead
import jsonschema  # noqa: F401 - loaded ahead
import matplotlib.backends.backend_svg
import matplotlib.figure  # noqa: F401 - loaded ahead

from moireid.badge import Badge, Lens, badge_from_json
from moireid.lenticule import ViewLaw, know_law
from moireid.provenance import ClaimedBadge
from moireid.registry import People
from moireid.sandbox.child import Talk
from moireid.verifier.limits import MIN_COVER_SHARE
from moireid.verifier.report.page import pictures_of, signals_csv
from moireid.verifier.session.capture import capture_as_built
from moireid.verifier.session.claim import Claim
from moireid.verifier.session.film import verify
from moireid.verifier.session.identify import identify

#: The signals of a film that was verified, in the folder of its job.
SIGNALS = "signals.csv"
#: What was made of an order, there too.
PACKAGE = "package.zip"
#: In the archive of an order: one badge as JSON; or a list of people.
ORDER, PEOPLE = "order.json", "people.csv"
#: A lens, a pitch (mm) and their law.
Law = tuple[Lens, float, ViewLaw]
#: Told how far a job is (done, of how many); what it has found; and asked what the server alone knows.
Progress = Callable[[int, int | None], None]
Tell = Callable[[dict[str, Any]], None]
Ask = Callable[[dict[str, Any]], Any]


@dataclass(frozen=True)
class Task:
    """What to do (a key of `work.WORK`, or of `making.WORK`), with the film of that name in its folder."""

    kind: str
    folder: Path
    video: str
    arguments: dict[str, Any] = field(default_factory=dict)


#: Least time between two reports of progress.
TELL_S = 0.1


def verify_film(
    video: Path,
    progress: Progress,
    tell: Tell,
    *,
    found: ClaimedBadge,
    focal_px: float | None = None,
    require_original: bool | None = None,
    cover_share: float = MIN_COVER_SHARE,
    photographs: int = 0,
    report: bool = False,
    laws: Sequence[Law] = (),
) -> None:
    """What `moireid verify --json` prints; with `report` also the pictures and the signals of its report.

    The page itself is made by the server, as this process is not to learn whose badge it has read.
    """
    _know(laws)
    claim = Claim(
        found.badge,
        found.badge.id,
        focal_px,
        found.as_built,
        require_original,
        found.provenance,
        cover_share,
        photographs,
        seal=found.seal,
    )
    made = verify(video, claim, barred=found.barred, progress=progress)
    tell({"result": made.to_json()})
    if not report:
        return
    pictures = pictures_of(made)
    for name, content in pictures.files.items():
        Path(name).write_bytes(content)
    Path(SIGNALS).write_text(signals_csv(made), encoding="utf-8")
    tell({"files": list(pictures.files), "plots": list(pictures.plots), "frame_s": pictures.frame_s})


@dataclass(frozen=True)
class RegistryClient:
    """The registry as identification sees it: the server answers each question, as this process must not reach it."""

    ask: Ask

    def holds(self, badge_id: str) -> bool:
        """Whether that id is enrolled, and its badge counts at present."""
        return bool(self.ask({"holds": badge_id}))

    def alike(self, parts: Mapping[int, str]) -> list[str]:
        """Ids, revoked or not, of which a part reads so."""
        return list(self.ask({"alike": dict(parts)}))


def identify_film(
    video: Path,
    progress: Progress,
    tell: Tell,
    *,
    ask: Ask,
    layouts: Sequence[Badge],
    focal_px: float | None = None,
    laws: Sequence[Law] = (),
) -> None:
    """What `moireid identify --json` prints, but the name and the registry: those are the server's own word."""
    _know(laws)
    tell({"result": identify(video, layouts, RegistryClient(ask), focal_px=focal_px, progress=progress).to_json()})


def measure_capture(video: Path, progress: Progress, tell: Tell, *, badge_json: str) -> None:
    """The as-built figures of the badge in a film, as `moireid enroll --capture` measures them; nothing is stored.

    Raises: MediaError where the film cannot be read or does not show this badge in motion.
    """
    badge = badge_from_json(badge_json)
    found = capture_as_built([video], badge, progress=progress)
    tell({"result": {"kind": "capture", "id": badge.id, "as_built": json.loads(found.to_json())}})


def _know(laws: Sequence[Law]) -> None:
    """Take laws that the server has traced already; tracing one here would take a third of a second."""
    for lens, pitch_mm, law in laws:
        know_law(lens, pitch_mm, law)


#: Kinds of work by name.  Each is called with the film, for progress and results, and with the task's arguments;
#: identify may ask as well.
WORK: dict[str, Callable[..., None]] = {
    "verify": verify_film,
    "identify": identify_film,
    "capture": measure_capture,
}


def judge(talk: Talk) -> None:
    """Do a task in this process, which then ends."""
    task: Task | None = talk.next()
    if task is None:
        return
    told_s = 0.0

    def progress(done: int, of: int | None) -> None:
        nonlocal told_s
        if time.monotonic() - told_s >= TELL_S:
            told_s = time.monotonic()
            talk.tell({"progress": [done, of]})

    def ask(question: dict[str, Any]) -> Any:
        talk.tell({"ask": question})
        return talk.next()

    os.chdir(task.folder)
    may_ask = {"ask": ask} if task.kind == "identify" else {}
    WORK[task.kind](Path(task.video), progress, talk.tell, **task.arguments, **may_ask)


_ID, _PART = re.compile("[0-9a-f]{1,64}"), re.compile("[0-9a-f]{4}")
PLACES = ("0", "1", "2", "3")
#: An honest film asks, for each layout: is the id that was read enrolled?  Or: which ids are alike, and is the one that
#: agrees enrolled (`verifier.session.identify`).  More questions would list the registry's ids.
MOST_OF_A_LAYOUT = 2


def answer_to(question: object, people: People | None) -> object:
    """The answer to `holds` (an id) or `alike` (parts by their place); an empty one to anything else.

    Raises: RegistryError where the registry fails.
    """
    asked = question if isinstance(question, dict) and people is not None else {}
    badge_id, parts = asked.get("holds"), asked.get("alike")
    if people is not None and isinstance(badge_id, str) and _ID.fullmatch(badge_id):
        return people.holds(badge_id)
    if people is not None and isinstance(parts, dict):
        right = {
            int(place): part
            for place, part in parts.items()
            if place in PLACES and isinstance(part, str) and _PART.fullmatch(part)
        }
        return people.alike(right)
    return []


def with_name(result: dict[str, Any], people: People) -> dict[str, Any]:
    """A result of identification with the name of the one who was found.  Raises: RegistryError."""
    found = result.get("found_id")
    return result | {"found_name": people.name(found) if isinstance(found, str) else None}
