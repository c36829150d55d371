"""What a hostile film would have its reader do, each by name: other processes import it."""

from __future__ import annotations

import ctypes
import fcntl
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from moireid.sandbox.child import Talk


def _connect(kind: int, family: int, address: Any) -> str:
    with socket.socket(family, kind) as made:
        made.settimeout(5)
        made.connect(address)
        made.send(b"x")
    return "sent"


def _environment_of(process: int) -> str:
    return str(len(Path(f"/proc/{process}/environ").read_bytes()) > 0)


def _linked(target: str) -> str:
    link = Path(tempfile.gettempdir()) / "link"
    link.symlink_to(target)
    return link.read_text()


def _fork() -> str:
    if not (child := os.fork()):
        os._exit(0)
    os.waitpid(child, 0)
    return "forked"


def _ptrace(process: int) -> str:
    libc = ctypes.CDLL(None, use_errno=True)
    # PTRACE_SEIZE, which stops nobody.
    if libc.ptrace(0x4206, process, None, None) != 0:
        raise OSError(ctypes.get_errno(), "ptrace")
    libc.ptrace(17, process, None, None)
    return "traced"


def _memory_of(process: int) -> str:
    with open(f"/proc/{process}/mem", "rb") as memory:
        return str(memory.readable())


def _threaded(path: str) -> str:
    found: list[object] = []

    def read() -> None:
        try:
            found.append(Path(path).read_text())
        except OSError as error:
            found.append(error)

    thread = threading.Thread(target=read)
    thread.start()
    thread.join()
    if isinstance(found[0], OSError):
        raise found[0]
    return str(found[0])


def _signal_by_file(process: int) -> str:
    """Have the kernel send a signal once a pipe can be read: to whom, and which, is anybody's choice.

    SIGURG harms nobody.
    """
    reader, writer = os.pipe()
    # 10: F_SETSIG.
    for command, argument in ((fcntl.F_SETOWN, process), (10, signal.SIGURG), (fcntl.F_SETFL, os.O_ASYNC)):
        fcntl.fcntl(reader, command, argument)
    os.write(writer, b"x")
    return "sent"


def _x32() -> str:
    """getpid by its x32 number; the filter ends a process that calls so."""
    return str(ctypes.CDLL(None).syscall(ctypes.c_long(0x40000000 + 39)))


ACTS: dict[str, Callable[..., str]] = {
    "read": lambda path: Path(path).read_text(),
    "read in a thread": _threaded,
    "read by a link": _linked,
    "list": lambda path: str(os.listdir(path)),
    "write": lambda path: str(Path(path).write_text("x")),
    "rights": lambda path: str(os.chmod(path, 0o644)),
    "tcp": lambda port: _connect(socket.SOCK_STREAM, socket.AF_INET, ("127.0.0.1", port)),
    "udp": lambda port: _connect(socket.SOCK_DGRAM, socket.AF_INET, ("127.0.0.1", port)),
    "unix": lambda path: _connect(socket.SOCK_STREAM, socket.AF_UNIX, path),
    "abstract": lambda name: _connect(socket.SOCK_STREAM, socket.AF_UNIX, f"\0{name}"),
    "listen": lambda: str(socket.create_server(("127.0.0.1", 0)).getsockname()),
    "program": lambda: str(subprocess.run([sys.executable, "-c", ""], check=True).returncode),
    "exec": lambda: str(os.execv(sys.executable, [sys.executable, "-c", "raise SystemExit(9)"])),
    "fork": _fork,
    "signal": lambda process: str(os.kill(process, 0)),
    "kill": lambda process: str(os.kill(process, signal.SIGTERM)),
    "signal by a file": _signal_by_file,
    "empty": lambda path: str(os.close(os.open(path, os.O_RDONLY | os.O_TRUNC))),
    "ptrace": _ptrace,
    "memory": _memory_of,
    "environment": _environment_of,
    "variable": lambda name: os.environ[name],
    "own environment": lambda name: str(name.encode() in Path("/proc/self/environ").read_bytes()),
    "x32": _x32,
    "scratch": lambda: str((Path(tempfile.gettempdir()) / "own").write_text("x")),
    "threads": lambda: str(
        [one.name for one in [threading.Thread(target=int) for _ in range(4)] if one.start() is None]
    ),
    "numpy": lambda: str(__import__("numpy").linalg.svd(__import__("numpy").eye(200))[1].sum()),
}


def act(talk: Talk) -> None:
    """Do what is asked; tell what came of it, or why not."""
    while (asked := talk.next()) is not None:
        name, *given = asked
        try:
            talk.send({"done": ACTS[name](*given)})
        except (OSError, KeyError, subprocess.SubprocessError) as error:
            talk.send({"refused": type(error).__name__, "errno": getattr(error, "errno", None)})
