"""What a source is, from what was typed."""

from __future__ import annotations

import re
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from moireid.errors import MediaError, SpecError

Kind = Literal["camera", "file", "pipe"]
KINDS = "a camera's number, a file, or - for a pipe"
#: An address, or a screen or window as it is named elsewhere.
ELSEWHERE = re.compile(r"[a-zA-Z][a-zA-Z0-9+.-]*://.*|screen(:.*)?", re.DOTALL)


@dataclass(frozen=True)
class Source:
    """A source of pictures.

    text: what opens it: a number, or a path; shown: its name in reports.
    """

    kind: Kind
    text: str
    shown: str

    def live(self, *, challenged: bool) -> bool:
        """Whether its times are checked against our clock: pictures of a pipe only where prompts are answered by it."""
        return self.kind == "camera" or (challenged and self.kind == "pipe")


def source_of(text: str) -> Source:
    """The source that was typed.

    Raises: SpecError where it is an address or a screen; MediaError where a file is not there.
    """
    if text == "-":
        return Source("pipe", text, "standard input")
    if re.fullmatch(r"[0-9]{1,2}", text):
        return Source("camera", text, f"camera {text}")
    if ELSEWHERE.fullmatch(text):
        # An address may hold a password, so it is not repeated.
        raise SpecError(
            "addresses and screens are not opened here; let FFmpeg write into a pipe "
            "(ffmpeg -i ADDRESS -c copy -f matroska - | moireid watch -), or give a camera's number or a file"
        )
    return _file(text)


def _file(text: str) -> Source:
    path = Path(text)
    try:
        found = path.stat()
    except (OSError, ValueError) as error:
        raise MediaError(f"source {text!r} does not exist; give {KINDS}") from error
    if stat.S_ISFIFO(found.st_mode):
        return Source("pipe", text, text)
    if not stat.S_ISREG(found.st_mode):
        raise MediaError(f"source {text!r} is no film and no pipe; give {KINDS}")
    return Source("file", str(path.absolute()), text)


def check_prompts(source: Source) -> None:
    """Raise SpecError where prompts cannot be answered through a source."""
    if source.kind == "file":
        raise SpecError(
            f"challenge= asks for moves, and {source.shown} is a film, which cannot answer; leave it out, or use a "
            "camera or a pipe"
        )
