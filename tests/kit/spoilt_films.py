"""Films that spoil or take over their reader: a sealed process imports this by name, so it needs but the ground."""

from __future__ import annotations

import os
import signal
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from moireid.errors import MediaError


@dataclass(frozen=True)
class Spoilt:
    """Stands for a film that spoils its reader: as an order, within the limits, it acts."""

    act: Callable[[], object]

    def __call__(self, *_: object) -> None:
        self.act()
        raise AssertionError("the process should not have come so far")


def crash() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def hang() -> None:
    time.sleep(1000)


def grow() -> None:
    held = [bytearray(1 << 26) for _ in range(100)]
    raise AssertionError(len(held))


@dataclass(frozen=True)
class Thief:
    """Reads what is not a film's: it says by a `MediaError` what it got."""

    paths: tuple[Path, ...]
    port: int

    def __call__(self) -> None:
        got = []
        for path in self.paths:
            with suppress(OSError):
                got += [path.name] if path.read_bytes() else []
        with suppress(OSError), socket.create_connection(("127.0.0.1", self.port), timeout=5):
            got.append("network")
        raise MediaError(f"the thief has {got}, and its own film of {len(Path('film.mp4').read_bytes())} bytes")
