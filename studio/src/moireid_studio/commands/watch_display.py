"""What `watch` shows: a panel on a terminal, lines elsewhere, or JSON lines."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from moireid.cli.common import (
    say,
    show_json,
    shown,
)

if TYPE_CHECKING:
    from rich.table import Table


Send = Callable[[dict[str, Any]], None]
COLOURS = {"accept": "green", "reject": "red", "inconclusive": "yellow"}
#: Findings of a running verdict that are shown.
MOST_FINDINGS = 4


def json_line(event: dict[str, Any]) -> None:
    """One object a line on stdout, at once."""
    show_json(event)
    sys.stdout.flush()


@contextmanager
def live_display(shown: str) -> Iterator[Send]:
    """A table on stderr that changes as it goes; without a terminal a line where something changes."""
    if not sys.stderr.isatty():
        yield _Lines().show
        return
    from rich.console import Console
    from rich.live import Live

    panel = _Panel(shown)
    with Live(panel.table(), console=Console(stderr=True), refresh_per_second=8, transient=True) as live:

        def show(event: dict[str, Any]) -> None:
            if (line := line_of(event)) is not None:
                live.console.print(f"{panel.elapsed}  {line}", markup=False, highlight=False)
            panel.take(event)
            live.update(panel.table())

        yield show


def line_of(event: dict[str, Any]) -> str | None:
    """An event in a line; None for a running verdict."""
    kind = event["event"]
    if kind == "begun":
        return f"pictures of {event['width']} x {event['height']}; Ctrl-C gives the verdict"
    if kind == "challenge":
        return f"{event['moves']} moves will be asked for; hold the badge still until the first"
    if kind == "prompt":
        return plain(f"{event['number']} of {event['of']}: {event['text']}")
    if kind == "prompted":
        return plain(f"{event['number']}: {event['reason']['text']}")
    return plain(event["text"]) if kind == "anew" else None


def plain(text: object) -> str:
    """Words without signs that steer a terminal."""
    return shown(str(text)[:400])


class _Lines:
    """What changes, line by line."""

    def __init__(self) -> None:
        self._begun, self._verdict = time.monotonic(), ""

    def show(self, event: dict[str, Any]) -> None:
        line = line_of(event)
        if event["event"] == "status" and event["verdict"] != self._verdict:
            self._verdict = event["verdict"]
            line = f"{plain(self._verdict)}: {plain(first_of(event))}"
        if line is not None:
            say(f"{time.monotonic() - self._begun:6.1f} s  {line}")


def first_of(event: dict[str, Any]) -> str:
    """The finding that a running verdict hangs on."""
    wanted = {"reject": ("fail",), "inconclusive": ("undecided", "fail")}.get(event["verdict"], ("pass",))
    found = [one["text"] for level in wanted for one in event["reasons"] if one["level"] == level]
    return str(found[0]) if found else ""


class _Panel:
    """The running verdict as a table."""

    def __init__(self, shown: str) -> None:
        self._shown, self._begun, self._status = shown, time.monotonic(), dict[str, Any]()

    @property
    def elapsed(self) -> str:
        return f"{time.monotonic() - self._begun:6.1f} s"

    def take(self, event: dict[str, Any]) -> None:
        if event["event"] == "status":
            self._status = event

    def table(self) -> Table:
        from rich.markup import escape
        from rich.table import Table

        table = Table.grid(padding=(0, 2))
        verdict = str(self._status.get("verdict", ""))
        colour = COLOURS.get(verdict, "white")
        words = escape(plain(verdict)) if verdict else "looking"
        table.add_row(f"[bold {colour}]{words.upper()}[/]", f"the last seconds of {escape(plain(self._shown))}")
        if self._status:
            seen = "the badge is in view" if self._status.get("badge") else "no badge is in view"
            table.add_row("", f"{seen}; {int(self._status.get('tracked', 0))} pictures of it are judged")
        for one in self._weightiest():
            table.add_row("", escape(plain(one["text"])))
        return table

    def _weightiest(self) -> list[dict[str, Any]]:
        order = {"fail": 0, "undecided": 1, "pass": 2}
        found = [one for one in self._status.get("reasons", ()) if one["level"] in order]
        return sorted(found, key=lambda one: order[one["level"]])[:MOST_FINDINGS]
