"""What a process does once a film has taken it over, as orders to read: sealed processes are sent them."""

from __future__ import annotations

import ctypes
import json
import os
import re
import signal
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

#: What a secret of a test looks like; the pattern is none itself.
SECRET = rb"hidden\.[0-9a-f]{12}"


@dataclass(frozen=True)
class HostileOrder:
    """An order that does something else than to read."""

    act: str
    path: str = ""

    def __call__(self, progress: Any) -> Iterator[dict[str, Any]]:
        """Do it, and give what came of it."""
        if self.act == "answer":
            yield json.loads(self.path)
        yield {"result": {"got": str(getattr(self, f"_{self.act}")())}}

    def _answer(self) -> None:
        """The answer, which `path` has as JSON, was sent before."""

    def _stop(self) -> None:
        os.kill(os.getpid(), signal.SIGSTOP)
        time.sleep(1000)

    def _spin(self) -> None:
        while True:
            pass

    def _grow(self) -> int:
        return len([bytearray(1 << 26) for _ in range(1000)])

    def _write(self) -> int:
        return Path(tempfile.gettempdir(), "large").write_bytes(bytes(1000))

    def _open(self) -> int:
        return len([os.dup(0) for _ in range(10_000)])

    def _steal(self) -> str:
        return Path(self.path).read_text()

    def _number(self) -> int:
        return os.getpid()

    def _look(self) -> dict[str, str]:
        return {"environment": Path("/proc/self/environ").read_text() + str(dict(os.environ))}

    def _search(self) -> int:
        """How often words like the test's secret are in this process's own memory."""
        found = 0
        for line in Path("/proc/self/maps").read_text().splitlines():
            first, last = (int(end, 16) for end in line.split()[0].split("-"))
            if line.split()[1].startswith("rw") and "[v" not in line:
                found += len(re.findall(SECRET, ctypes.string_at(first, last - first)))
        return found


def take_over(order: HostileOrder, film: str) -> str:
    """A job of a collection that its film has taken over."""
    (found,) = order(None)
    return str(found["result"]["got"])


@dataclass(frozen=True)
class SayingOrder:
    """An order whose reader sends a message of the attacker's; bytes: as they are, which need be no JSON."""

    message: Any

    def __call__(self, progress: Any) -> Iterator[dict[str, Any]]:
        """Send it, and a result."""
        if isinstance(self.message, bytes):
            progress.__self__._pipe.send_bytes(self.message)
        else:
            yield self.message
        yield {"result": {}}
