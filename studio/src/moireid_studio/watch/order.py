"""The messages between the process that judges and the one that started it.

To the judge: a `WatchOrder`, then `Data`, `Shot` and `StreamEnd`.  Its answers are JSON: events of the check
(`moireid_studio.challenge`), and what it asks for:

want     {"want": B}: so many bytes of the pipe at most
event    begun (size), status, challenge, prompt, prompted, anew, verdict, error
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from moireid_studio.watch.source import Source

if TYPE_CHECKING:
    from moireid.question import Question
    from moireid_studio.challenge.challenge import Prompt

Event = dict[str, Any]
#: Bytes that the judge asks for at a time.
PIECE = 1 << 16
#: Pictures of more pixels are refused: 4K.  A stream must be judged as fast as it comes.
MOST_PIXELS = 4096 * 2304
LEAST_SIDE = 120


@dataclass(frozen=True)
class Patience:
    """How long to wait, s: for the first picture, for each further one, and for a file to grow until it is whole."""

    open_s: float = 30.0
    stall_s: float = 10.0
    grown_s: float = 5.0


@dataclass(frozen=True)
class WatchOrder:
    """What to judge.  prompts: of a challenge, their times counted from its beginning; None where none is asked for."""

    source: Source
    question: Question
    prompts: Sequence[Prompt] | None = None
    patience: Patience = field(default_factory=Patience)


@dataclass(frozen=True)
class Data:
    """Bytes of the pipe, and when they came, s; none at its end.  error: why it gives none."""

    content: bytes
    arrival_s: float
    error: str | None = None


@dataclass(frozen=True)
class Shot:
    """A picture's brightness, height x width bytes, when it was taken by its own clock, and when it came by ours, s."""

    luma: bytes
    size: tuple[int, int]
    claimed_s: float
    arrival_s: float


@dataclass(frozen=True)
class StreamEnd:
    """The wish for the verdict on what came so far.

    why: it was asked for, the source has ended, it gave nothing for a while, or it failed; words: for the last two.
    """

    why: Literal["asked", "source", "silent", "failed"] = "asked"
    words: str = ""
