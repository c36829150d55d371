"""A piece of work as it is given to its own process.

The server loads this file and not `work.py`, because it does not need the packages of the work itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from moireid.badge import Lens
from moireid.lenticule import ViewLaw

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
