"""What tests have done within limits: other processes import it by name."""

from __future__ import annotations

import json
import os
import pickle
import signal
import struct
import tempfile
import time
from pathlib import Path
from typing import Any

from moireid.errors import MediaError
from moireid.sandbox.child import Talk


class Trap:
    """A pickle that makes a file where it is read."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return Path.touch, (self.path,)


def act(talk: Talk) -> None:
    """Do what is asked, by name."""
    while (asked := talk.next()) is not None:
        name, *given = asked
        if name == "describe":
            where = {"folder": tempfile.gettempdir(), "pid": os.getpid(), "parent": os.getppid()}
            talk.send(where | {"json": json.__file__, "threads": os.environ.get("OPENCV_FOR_THREADS_NUM")})
        elif name == "grow":
            bytearray(given[0])
            talk.send({"grown": given[0]})
        elif name == "write":
            (Path(tempfile.gettempdir()) / "large").write_bytes(bytes(given[0]))
        elif name == "spin":
            while True:
                pass
        elif name == "hang":
            time.sleep(600)
        elif name == "crash":
            os.kill(os.getpid(), signal.SIGSEGV)
        elif name == "leave":
            os._exit(7)
        elif name == "raw":
            talk._pipe.send_bytes(given[0])
        elif name == "promise":
            # The length of a message, and the first byte of it.
            os.write(talk._pipe.fileno(), struct.pack("!i", 1 << 15) + b"{")
            time.sleep(600)
        elif name == "trap":
            talk._pipe.send_bytes(pickle.dumps(Trap(given[0])))
        elif name == "refuse":
            raise MediaError("no\nfilm")
        elif name == "fail":
            raise LookupError("nothing there")
        elif name == "end":
            return
