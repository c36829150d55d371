"""Reading a JSON object of any size: the items of its arrays one by one, in little memory."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NoReturn, TextIO

CHUNK = 2**20
#: A single value longer than this is no record, letters.
VALUE_LIMIT = 2**27
#: Letters of "e-", which belong to a number only once a digit follows.
LONGEST_CUT = 2


def walk(stream: TextIO) -> Iterator[tuple[str, Any]]:
    """What the object in `stream` holds, in order: (key, value), and for an array (key, item) of each item.

    White space may stand wherever JSON allows it.
    Raises: ValueError where the text is not one JSON object, at the place where it is reached.
    """
    reader = _Reader(stream)
    reader.expect("{")
    if reader.peek() != "}":
        while True:
            key = reader.value()
            if not isinstance(key, str):
                raise ValueError("a key is not text")
            reader.expect(":")
            if reader.peek() == "[":
                for item in reader.items():
                    yield key, item
            else:
                yield key, reader.value()
            if reader.peek() != ",":
                break
            reader.expect(",")
    reader.expect("}")
    if reader.peek():
        raise ValueError("there is more after its end")


class _Reader:
    """Values from a stream; the buffer holds little more than the one being read."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._decoder = json.JSONDecoder(parse_constant=_refuse)
        self._buffer = ""
        self._at = 0
        self._ended = False

    def peek(self) -> str:
        """The next letter that is no white space, or "" at the end."""
        while True:
            while self._at < len(self._buffer) and self._buffer[self._at] in " \t\r\n":
                self._at += 1
            if self._at < len(self._buffer):
                return self._buffer[self._at]
            if not self._more(CHUNK):
                return ""

    def expect(self, letter: str) -> None:
        """Pass over `letter`."""
        found = self.peek()
        if found != letter:
            raise ValueError(f"{letter!r} is missing" if found else "it ends too early")
        self._at += 1

    def value(self) -> Any:
        """The next value, of any kind."""
        self.peek()
        size = CHUNK
        while True:
            try:
                value, end = self._decoder.raw_decode(self._buffer, self._at)
            except json.JSONDecodeError as error:
                # Cut off by the buffer's end, as it seems: more is read, each time twice as much.
                if len(self._buffer) - self._at > VALUE_LIMIT or not self._more(size):
                    raise ValueError(error.msg) from error
            except RecursionError as error:
                raise ValueError("it is nested too deep") from error
            else:
                # A number near the buffer's end may go on with digits, or with a point or exponent cut in two.
                sure = not isinstance(value, int | float) or len(self._buffer) - end > LONGEST_CUT
                if sure or not self._more(size):
                    self._at = end
                    return value
            size *= 2

    def items(self) -> Iterator[Any]:
        """The items of the next array."""
        self.expect("[")
        if self.peek() != "]":
            while True:
                yield self.value()
                if self.peek() != ",":
                    break
                self.expect(",")
        self.expect("]")

    def _more(self, size: int) -> bool:
        """Read on, and drop what is behind; false at the end."""
        content = "" if self._ended else self._stream.read(size)
        self._ended = not content
        if content:
            self._buffer = self._buffer[self._at :] + content
            self._at = 0
        return bool(content)


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number")
