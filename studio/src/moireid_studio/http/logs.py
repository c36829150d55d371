"""The server's log: a line of JSON for each event, without names, addresses or tokens.

An error's words may name a person, so the log says its kind and the places in the program, and not its words.
"""

from __future__ import annotations

import json
import logging
import sys
import time
import traceback
from collections import Counter
from datetime import UTC, datetime
from typing import Any

#: Lines of one kind within a minute; further ones are counted, and their number is written with the next line.
MOST_A_MINUTE = 20
#: The program's logger, and the one of requests alone.
OURS, REQUESTS = "moireid", "moireid.requests"


class Lines(logging.Formatter):
    """A record as one line of JSON; an error is replaced by its kind."""

    def format(self, record: logging.LogRecord) -> str:
        at = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        fields: dict[str, Any] = {
            "at": at,
            "level": record.levelname.lower(),
            "from": record.name,
            "event": _words(record),
        }
        fields |= getattr(record, "fields", {})
        if left_out := getattr(record, "left_out", 0):
            fields["left_out"] = left_out
        if record.exc_info and (error := record.exc_info[1]) is not None:
            fields["error"] = type(error).__name__
            frames = traceback.extract_tb(error.__traceback__)
            fields["at_lines"] = [f"{_short(frame.filename)}:{frame.lineno} {frame.name}" for frame in frames]
        return json.dumps(fields, ensure_ascii=False)


class Seldom(logging.Filter):
    """Lets a limited number of lines of a kind pass: a client that sends rubbish must not fill the disk."""

    def __init__(self) -> None:
        super().__init__()
        self._minute, self._seen, self._left_out = 0, Counter[str](), Counter[str]()

    def filter(self, record: logging.LogRecord) -> bool:
        if record.name == REQUESTS:
            return True
        minute, kind = int(time.time() // 60), f"{record.name} {record.msg}"
        if minute != self._minute:
            self._minute, self._seen = minute, Counter()
        self._seen[kind] += 1
        if self._seen[kind] > MOST_A_MINUTE:
            self._left_out[kind] += 1
            return False
        record.left_out = self._left_out.pop(kind, 0)
        return True


def begin(*, as_json: bool) -> None:
    """Write this process's log to stderr: warnings of all, and with `as_json` each request too, as lines of JSON."""
    handler = logging.StreamHandler(sys.stderr)
    handler.addFilter(Seldom())
    handler.setFormatter(Lines() if as_json else logging.Formatter("%(levelname)s: %(message)s"))
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(logging.WARNING)
    logging.getLogger(REQUESTS).setLevel(logging.INFO if as_json else logging.WARNING)


def note_request(method: str, route: str, status: int, seconds: float) -> None:
    """Log an answer: the route's pattern, and no part of the address that was asked for."""
    fields = {"method": method, "route": route, "status": status, "ms": round(1000 * seconds, 1)}
    logging.getLogger(REQUESTS).info("request", extra={"fields": fields})


def _words(record: logging.LogRecord) -> str:
    args = record.args
    if isinstance(args, tuple) and args:
        record.args = tuple(type(one).__name__ if isinstance(one, BaseException) else one for one in args)
    return record.getMessage()


def _short(path: str) -> str:
    """A file's place in its package: the folders before it are the machine's own."""
    return "/".join(path.replace("\\", "/").split("/")[-3:])
