"""The process behind one live session: pictures in on stdin, events out on stdout.

It is started by `live` for each session, so that what a stranger's pictures do to the decoder they do to this process
alone, which has limits of memory and time and is ended with the session.

Messages on stdin: a kind, two times and a length (`HEADER`), then so many bytes.  START: JSON of badge and claim; ASK:
JSON of prompts; FRAME: a JPEG with its arrival by our clock and its claimed time; END.  Events are JSON, one a line.
"""

from __future__ import annotations

import json
import os
import struct
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any, BinaryIO

#: Kind, arrival and claimed time (s), length in bytes.
HEADER = struct.Struct(">cddI")
START, ASK, FRAME, END = b"S", b"A", b"F", b"E"
#: Pictures of more than this many pixels are not decoded: a camera's page asks for 720p.
MOST_PIXELS = 1920 * 1088
LEAST_SIDE = 120
#: Processor time and private memory of a session.
CPU_S, MEMORY_BYTES = 600, 1 << 30


def main() -> None:
    """Serve one session, and leave."""
    _limit()
    source = sys.stdin.buffer
    kind, _, _, body = read_message(source)
    if kind != START:
        return
    from moireid.errors import MoireIdError

    try:
        _serve(source, json.loads(body))
    except MoireIdError as error:
        tell({"event": "error", "text": " ".join(str(error).split())})


def _serve(source: BinaryIO, start: dict[str, Any]) -> None:
    import cv2

    from moireid.asbuilt import as_built_from_json
    from moireid.badge import badge_from_json
    from moireid.verifier.live.challenge import Prompt
    from moireid.verifier.live.session import LiveCheck
    from moireid.verifier.session.claim import Claim

    # The running verdict has a thread of its own; one more would take time from other sessions.
    cv2.setNumThreads(1)
    badge = badge_from_json(start["badge"])
    as_built = as_built_from_json(start["as_built"]) if start["as_built"] else None
    prompts: list[Prompt] = []

    def draw(start_s: float) -> list[Prompt]:
        return [Prompt(prompt.move, start_s + prompt.at_s) for prompt in prompts]

    with ThreadPoolExecutor(1, "verdict") as aside:
        check = LiveCheck(Claim(badge, start["claimed_id"], as_built=as_built), draw=draw, aside=aside)
        tell({"event": "ready"})
        size, taken = None, 0
        while not check.ended:
            kind, arrival_s, claimed_s, body = read_message(source)
            if kind == FRAME:
                luma = picture(body)
                if luma is None or (size is not None and luma.shape != size):
                    tell({"event": "error", "text": "A picture could not be read; it must be a JPEG of an even size."})
                    return
                size, taken = luma.shape, taken + 1
                for event in check.push(luma, claimed_s, arrival_s):
                    tell(event)
                tell({"event": "taken", "frames": taken})
            elif kind == ASK:
                prompts = [Prompt(move, at_s) for move, at_s in json.loads(body)]
                check.ask(arrival_s)
            elif kind == END:
                tell(check.finish())
            else:
                return


def picture(body: bytes) -> Any:
    """A JPEG's brightness, (height, width) uint8; None where it is none, or too large or too small."""
    import cv2
    import numpy as np

    if body[:2] != b"\xff\xd8":
        return None
    try:
        luma = cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_GRAYSCALE)
    except cv2.error:
        return None
    return luma if luma is not None and min(luma.shape) >= LEAST_SIDE else None


def tell(event: dict[str, Any]) -> None:
    """Write one event."""
    sys.stdout.buffer.write(json.dumps(event, allow_nan=False).encode() + b"\n")
    sys.stdout.buffer.flush()


def read_message(source: BinaryIO) -> tuple[bytes, float, float, bytes]:
    """The next message; one of no kind where there is none any more."""
    header = source.read(HEADER.size)
    if len(header) < HEADER.size:
        return b"", 0.0, 0.0, b""
    kind, arrival_s, claimed_s, length = HEADER.unpack(header)
    return kind, arrival_s, claimed_s, source.read(length)


def _limit() -> None:
    """Limits of this process, where the system knows them."""
    # Read by OpenCV as it is loaded: it looks at a picture's size before it makes room for it.
    os.environ["OPENCV_IO_MAX_IMAGE_PIXELS"] = str(MOST_PIXELS)
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S + 5))
    if sys.platform == "linux":
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))


if __name__ == "__main__":
    main()
