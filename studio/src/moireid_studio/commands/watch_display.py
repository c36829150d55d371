"""What `watch` shows: lines for people, or JSON lines."""

from __future__ import annotations

import sys
import time
from typing import Any

from moireid.cli.common import say, show_json

#: Letters of a line at most: its words may be a decoder's that was taken over.
LONGEST = 400


def json_line(event: dict[str, Any]) -> None:
    """One object a line on stdout, at once."""
    show_json(event)
    sys.stdout.flush()


def line_of(event: dict[str, Any]) -> str | None:
    """An event in a line; None for a running verdict."""
    kind = event["event"]
    if kind == "begun":
        return f"pictures of {event['width']} x {event['height']}; Ctrl-C gives the verdict"
    if kind == "challenge":
        return f"{event['moves']} moves will be asked for; hold the badge still until the first"
    if kind == "prompt":
        return f"{event['number']} of {event['of']}: {event['text']}"
    if kind == "prompted":
        return f"{event['number']}: {event['reason']['text']}"
    return str(event["text"]) if kind == "anew" else None


class LiveLines:
    """What changes, line by line on stderr."""

    def __init__(self) -> None:
        self._begun, self._verdict = time.monotonic(), ""

    def show(self, event: dict[str, Any]) -> None:
        """Show an event, where it changes something."""
        line = line_of(event)
        if event["event"] == "status" and event["verdict"] != self._verdict:
            self._verdict = event["verdict"]
            line = f"{self._verdict}: {first_of(event)}"
        if line is not None:
            say(f"{time.monotonic() - self._begun:6.1f} s  {line[:LONGEST]}")


def first_of(event: dict[str, Any]) -> str:
    """The finding that a running verdict hangs on."""
    wanted = {"reject": ("fail",), "inconclusive": ("undecided", "fail")}.get(event["verdict"], ("pass",))
    found = [one["text"] for level in wanted for one in event["reasons"] if one["level"] == level]
    return str(found[0]) if found else ""
