"""A piece of work that a process is given.

It loads none of the packages that the work needs, so that the server does not pay for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from moireid.badge import Lens
from moireid.lenticule import ViewLaw
from moireid.reading.film_orders import Order

#: The signals of a film that was verified, in the folder of its job.
SIGNALS = "signals.csv"
#: What was made of an order, there too.
PACKAGE = "package.zip"
#: In the archive of an order: one badge as JSON; or a list of people.
ORDER, PEOPLE = "order.json", "people.csv"
#: A lens, a pitch (mm) and their law.
Law = tuple[Lens, float, ViewLaw]
#: Callbacks: how far a job is (done, of how many); a message to the server.
Progress = Callable[[int, int | None], None]
Send = Callable[[dict[str, Any]], None]


@dataclass(frozen=True)
class Task:
    """What to do, with the film of that name in its folder.

    kind: a key of `issue_work.WORK`, or of a film; order: what is read of a film; laws: that the server has traced
    already, as tracing one there would take a third of a second; arguments: of other work.
    """

    kind: str
    folder: Path
    video: str
    order: Order | None = None
    laws: Sequence[Law] = ()
    arguments: dict[str, Any] = field(default_factory=dict)
