"""Reading a JSON object of any size: the items of its arrays one by one, in little memory."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, BinaryIO

import ijson

CHUNK = 2**16
#: Largest single value, bytes; no record is longer.
VALUE_LIMIT = 2**27
#: A record's documents are a handful of levels deep.
DEEPEST = 200

_BEGIN = frozenset(["start_map", "start_array"])
_Events = Iterator[tuple[str, Any]]


def walk(stream: BinaryIO) -> Iterator[tuple[str, Any]]:
    """What the object in `stream` holds, in order: (key, value), and for an array (key, item) of each item.

    White space may stand wherever JSON allows it.
    Raises: ValueError where the bytes are not one JSON object, at the place where it is reached.
    """
    limited = _Limited(stream)
    try:
        for found in _walk(ijson.basic_parse(limited, use_float=True, buf_size=CHUNK)):
            yield found
            limited.left = VALUE_LIMIT
    except ijson.JSONError as error:
        # The parser's text goes on with an extract of the file, over several lines.
        words = str(error)
        not_text = "UTF8" in words or "utf-8" in words
        raise ValueError("it is not UTF-8 text" if not_text else words.splitlines()[0]) from error


def _walk(events: _Events) -> _Events:
    if next(events) != ("start_map", None):
        raise ValueError("it is no JSON object")
    for _, key in _until("end_map", events):
        event, value = next(events)
        if event == "start_array":
            yield from ((key, _whole(events, *item)) for item in _until("end_array", events))
        else:
            yield key, _whole(events, event, value)
    # The parser sees whether anything follows.
    next(events, None)


def _whole(events: _Events, event: str, value: Any, levels: int = DEEPEST) -> Any:
    """The value that begins with this event.  Raises: ValueError where it is nested too deep."""
    if event not in _BEGIN:
        return value
    if not levels:
        raise ValueError(f"it is nested deeper than {DEEPEST} levels")
    if event == "start_array":
        return [
            _whole(events, event, value, levels - 1) if event in _BEGIN else value
            for event, value in _until("end_array", events)
        ]
    made = {}
    for _, key in _until("end_map", events):
        event, value = next(events)
        made[key] = _whole(events, event, value, levels - 1) if event in _BEGIN else value
    return made


def _until(end: str, events: _Events) -> _Events:
    """The events before the next `end` that nobody took; the parser sees that it comes."""
    return iter(partial(next, events), (end, None))


class _Limited:
    """A stream that gives no more than `left` bytes, which is set anew with every value."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self.left = stream, VALUE_LIMIT

    def read(self, size: int) -> bytes:
        content = self._stream.read(size)
        self.left -= len(content)
        if self.left < 0:
            raise ValueError(f"a value of it is longer than {VALUE_LIMIT} bytes")
        return content
