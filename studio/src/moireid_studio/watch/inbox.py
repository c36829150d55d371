"""What waits to be judged: pictures, at most so many, and messages."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import Any

from moireid.verifier.picture import Picture

#: Pictures that wait; with 4K pictures that is 80 MB.
AHEAD = 8


@dataclass(frozen=True)
class TimedPicture:
    """A picture, when it was taken by its own clock, and when it came by ours, s."""

    picture: Picture
    claimed_s: float
    arrival_s: float


class Inbox:
    """Pictures in order, and messages, which come first.

    A source that does not wait for us loses its oldest picture where too many wait; one that does is held up.
    """

    def __init__(self, *, waits: bool) -> None:
        self._waits, self._taken, self._messages = waits, deque[TimedPicture | None](), deque[Any]()
        self._room = threading.Condition()
        #: Pictures that came faster than they could be judged.
        self.lost = 0

    def put(self, message: Any) -> None:
        """Leave a message."""
        with self._room:
            self._messages.append(message)
            self._room.notify_all()

    def put_picture(self, taken: TimedPicture) -> None:
        """Leave a picture; a source that waits does so until there is room."""
        with self._room:
            if self._waits:
                self._room.wait_for(lambda: len(self._taken) < AHEAD)
            elif len(self._taken) >= AHEAD:
                self._taken.popleft()
                self.lost += 1
            self._taken.append(taken)
            self._room.notify_all()

    def put_last(self, message: Any) -> None:
        """Leave a message that counts once the pictures before it are judged."""
        with self._room:
            self._room.wait_for(lambda: not self._taken, timeout=60)
            self._messages.append(message)
            self._room.notify_all()

    def get(self, seconds: float | None) -> Any:
        """The next message or picture; None where nothing comes for so long."""
        with self._room:
            if not self._room.wait_for(lambda: self._messages or self._taken, timeout=seconds):
                return None
            item = self._messages.popleft() if self._messages else self._taken.popleft()
            self._room.notify_all()
            return item
