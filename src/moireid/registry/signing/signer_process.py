"""The process with the key: `moireid registry signer`, or `python -m moireid.registry.signing.signer_process SOCKET`.

It reads keys from the keys folder, answers at a Unix socket, and does three things: say whether it has a key, make one,
and sign texts of the accepted kinds (`client.py`).  It never gives a key away.  It opens no registry, no film and no
network connection.
"""

from __future__ import annotations

import os
import socket
import socketserver
import struct
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import msgspec

from moireid.errors import MoireIdError, RegistryError, SpecError
from moireid.registry.keys import Authority, Signer, key_of, new_key
from moireid.registry.log import ROTATE
from moireid.registry.signing.client import (
    DOMAINS,
    LOG_ENTRY,
    LONGEST,
    SignerMessage,
    entry_of,
    of_kind,
    turn_of,
)

#: Longest message, bytes: the content in base64, and the JSON around it.
MESSAGE = 2 * LONGEST
NONE_OF_THEM = {"refused": "it signs records, log entries, checkpoints and bundles, and this is none of them"}
#: A client that is silent for this many seconds is disconnected, and may connect again; most clients at one time.
IDLE_S, MOST_CLIENTS = 5, 64
#: How long the studio waits for its signer to listen, seconds.
START_S = 60.0


class Keys:
    """The keys that were asked for, each read once; and those that were made here and have no log yet."""

    def __init__(self) -> None:
        self._signers: dict[str, Signer] = {}
        self._fresh: set[str] = set()

    def answer(self, message: bytes) -> dict[str, str]:
        """The answer to a message; "refused" with a sentence if it is refused."""
        try:
            asked = msgspec.json.decode(message, type=SignerMessage)
            if asked.do == "make":
                made = new_key()[0].authority.public_hex
                self._fresh.add(made)
                return {"public": made}
            signer = self._signer(asked.public)
            if asked.do == "know":
                return {"fingerprint": signer.authority.fingerprint}
            if asked.kind == LOG_ENTRY:
                return self._entry(signer, asked.content)
            if not of_kind(asked.kind, asked.content, signer.authority.fingerprint):
                return NONE_OF_THEM
            return {"signature": signer.sign(DOMAINS[asked.kind], asked.content)}
        except MoireIdError as error:
            return {"refused": " ".join(str(error).split())}
        except (ValueError, RecursionError):
            return {"refused": "the question cannot be read"}

    def _entry(self, signer: Signer, text: bytes) -> dict[str, str]:
        """Sign a log entry.  A change of key is signed only to a key that this process made, and that has no log yet.

        Else a client with temporary access could give the log to a key of their own, or to an old one that was stolen.
        """
        entry, public = entry_of(text), signer.authority.public_hex
        if entry is None:
            return NONE_OF_THEM
        if entry.action == ROTATE:
            turn = turn_of(entry)
            if turn is None or public not in turn or turn[1] not in self._fresh or turn[0] == turn[1]:
                return {"refused": "it gives a log only to a new key that it made itself; ask it for the whole change"}
        answer = {"signature": signer.sign_entry(text)}
        self._fresh.discard(public)
        return answer

    def _signer(self, public: str) -> Signer:
        if public not in self._signers:
            self._signers[public] = key_of(Authority(public))
        return self._signers[public]


class _Server(socketserver.ThreadingUnixStreamServer):
    daemon_threads = True

    def __init__(self, path: str, mode: int) -> None:
        self.keys, self._places = Keys(), threading.BoundedSemaphore(MOST_CLIENTS)
        # No client may connect before the file's permissions are set.
        before = os.umask(0o177)
        try:
            super().__init__(path, _Handler)
        finally:
            os.umask(before)
        os.chmod(path, mode)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a client if there is a free place: without a limit, open sockets could use up all that there are."""
        if self._places.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a client, then give its place back."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._places.release()


class _Handler(socketserver.BaseRequestHandler):
    server: _Server

    def handle(self) -> None:
        """Answer a client until it disconnects or stays silent."""
        for way in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            self.request.setsockopt(socket.SOL_SOCKET, way, struct.pack("ll", IDLE_S, 0))
        with suppress(OSError, EOFError), Connection(os.dup(self.request.fileno())) as line:
            while True:
                line.send_bytes(msgspec.json.encode(self.server.keys.answer(line.recv_bytes(MESSAGE))))


def serve(path: Path, group: str | None = None, *, ready: Callable[[], None] = lambda: None) -> None:
    """Listen until this process is ended.

    Parameters: group: a group of the system, whose members may ask, too; None: this user alone.
    Raises: SpecError if the socket cannot be made, or another signer listens there.
    """
    _close_memory()
    _clear(path)
    own = False
    try:
        with _Server(str(path), 0o600 if group is None else 0o660) as server:
            own = True
            if group is not None:
                _give(path, group)
            ready()
            server.serve_forever()
    except OSError as error:
        raise SpecError(
            f"no signer can listen at {path} ({error.strerror or error}); give a path of at most 100 letters in a "
            "folder that you may write"
        ) from error
    finally:
        # Where another signer was quicker, the socket is that one's.
        if own:
            path.unlink(missing_ok=True)


@contextmanager
def own_signer() -> Iterator[str]:
    """A signer for as long as this lasts, as a process of this user; gives the path of its socket.

    It ends with this process, however that ends.  Raises: RegistryError if it cannot be started.
    """
    with tempfile.TemporaryDirectory(prefix="moireid-signer-") as folder:
        path = str(Path(folder) / "socket")
        command = [sys.executable, "-P", "-m", "moireid.registry.signing.signer_process", path]
        imports = os.pathsep.join(name for name in sys.path if name)
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ | {"PYTHONPATH": imports}
        ) as process:
            try:
                if process.stdout is None or process.stdout.readline() != b"ready\n":
                    raise RegistryError("the process that is to sign for the registry could not be started; try again")
                yield path
            finally:
                process.kill()


def main() -> None:
    """Run as the studio starts it: it ends when its standard input is closed, of which the studio has the other end."""
    threading.Thread(target=_leave_with_input, daemon=True).start()
    serve(Path(sys.argv[1]), ready=lambda: print("ready", flush=True))  # noqa: T201 - its starter waits for this


def _leave_with_input() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


def _close_memory() -> None:
    """No core file, and no look into this process for others of the same user.

    Source: prctl(2), PR_SET_DUMPABLE.
    """
    import ctypes
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(4, 0, 0, 0, 0)


def _clear(path: Path) -> None:
    """Remove the socket that an ended signer left.  Raises: SpecError if one listens there, or it is another file."""
    if not path.exists():
        return
    # A plain file has no listener either, but must not be deleted as if it were an old socket.
    if not path.is_socket():
        raise SpecError(f"{path} is no socket of a signer; give another path")
    with socket.socket(socket.AF_UNIX) as line:
        if line.connect_ex(str(path)) == 0:
            raise SpecError(f"a signer listens at {path} already; stop it, or give another path")
    path.unlink()


def _give(path: Path, group: str) -> None:
    import grp

    try:
        os.chown(path, -1, grp.getgrnam(group).gr_gid)
    except (KeyError, PermissionError) as error:
        raise SpecError(f"the socket cannot be given to group {group!r}; name one that you are a member of") from error


if __name__ == "__main__":
    main()
