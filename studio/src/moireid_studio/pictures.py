"""Visitors' logos and portraits: read in a process of their own, and kept until their badge is made.

What is kept is what that process made of them (`picture_work.py`), for one visitor and for as long as results are.
A file's own name is shown and compared, and never becomes a path.
"""

from __future__ import annotations

import base64
import binascii
import json
import tempfile
import threading
import time
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from moireid.artwork.content import forget_pictures
from moireid.artwork.pictures import ADVICE
from moireid.artwork.svg import MOST_SECONDS, too_slow
from moireid.errors import SpecError
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import Child, ForkServer, ProcessEnd
from moireid.sandbox.seal import ProcessLimits
from moireid_studio.auth.guard import Visitor
from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits
from moireid_studio.store.job import JOB_ID, Job
from moireid_studio.store.stored_pictures import StoredPicture, unpacked, written
from moireid_studio.studio import Studio

#: The kind of job that holds a visitor's pictures, and the file that they are in.
KIND, FILE = "pictures", "pictures.zip"
#: Begins with the first picture, and loads what reads them once.
readers = ForkServer("moireid_studio.picture_work:read_pictures", sealed=True)
#: So many processes read pictures at a time; a visitor who waits longer than that for one is refused.
AT_A_TIME, WAIT_S = 2, 30.0
_places = threading.BoundedSemaphore(AT_A_TIME)
#: Answers: a picture of `picture_work.MOST_BYTES` in letters, and its frame.
ANSWER_BYTES = 8 << 20
START_S, SCRATCH_BYTES = 60.0, 1 << 20
#: How long the pictures of one form may be read, all together.
FORM_SECONDS = 180.0


def read_pictures(sent: Sequence[tuple[str, StoredPicture]], limits: Limits) -> list[StoredPicture | SpecError]:
    """Each picture as our own process makes it of what was sent, or why it cannot be used.

    Parameters
    ----------
    sent
        What each is, for messages, and the picture.

    Raises
    ------
    Refusal
        503 where too many wait, or no process can be started.
    """
    if not sent:
        return []
    if not _places.acquire(timeout=WAIT_S):
        text = "Too many pictures wait to be read; try again in a minute."
        raise Refusal(503, "busy", text, headers={"Retry-After": "60"})
    reader, last, room = Reader(limits), time.monotonic() + FORM_SECONDS, limits.pictures_bytes
    found: list[StoredPicture | SpecError] = []
    try:
        for what, one in sent:
            whose = f"{what} {one.name}" if one.name else what
            if time.monotonic() > last:
                text = f"the pictures take longer than {FORM_SECONDS:g} s together; send fewer at a time"
                found.append(SpecError(text))
                continue
            made = reader.read(whose, one)
            # Small drawings can be large pictures.
            room -= len(made.data) if isinstance(made, StoredPicture) else 0
            text = f"the pictures are too large together, from {whose} on; send smaller ones"
            found.append(made if room >= 0 else SpecError(text))
        return found
    except OSError as error:
        raise Refusal(503, "system", f"No picture can be read just now ({error.strerror}); try again later.") from error
    finally:
        reader.end()
        _places.release()


def read_picture(what: str, picture: StoredPicture, limits: Limits) -> StoredPicture:
    """The same for one.  Raises: SpecError; Refusal as `read_pictures`."""
    made = read_pictures([(what, picture)], limits)[0]
    if isinstance(made, SpecError):
        raise made
    return made


class Reader:
    """Processes that read pictures and can do nothing else, one after the other: a picture may end the one it meets."""

    def __init__(self, limits: Limits) -> None:
        self._most = limits.picture_bytes
        self._limits = ProcessLimits(limits.memory_bytes, int(limits.job_s), SCRATCH_BYTES, ANSWER_BYTES)
        self._child: Child | None = None

    def read(self, whose: str, picture: StoredPicture) -> StoredPicture | SpecError:
        """What a process makes of a picture.  Raises: OSError where none can be started."""
        if len(picture.data) > self._most:
            return SpecError(f"{whose} is larger than {self._most / 1e6:.0f} MB; {ADVICE} that is smaller")
        if self._child is None:
            self._child = readers.fork(self._limits, within=reach())
            # It has sealed itself by then; where that ends it, the next lines say so.
            with suppress(ProcessEnd):
                self._child.hear(START_S)
        last = time.monotonic() + MOST_SECONDS
        try:
            self._child.send((picture.data, whose), MOST_SECONDS)
            answer = self._child.hear(max(last - time.monotonic(), 0.0))
        except ProcessEnd:
            self.end()
            return SpecError(f"{whose} takes more memory than a picture may have here; {ADVICE} that is smaller")
        if answer is None:
            self.end()
            return too_slow(whose)
        if "fault" in answer:
            return SpecError(str(answer["fault"]))
        try:
            made = StoredPicture(picture.name, base64.b64decode(str(answer.get("picture")), validate=True))
        except binascii.Error:
            made = StoredPicture("", b"")
        # No honest process hands back another kind of picture.
        return made if made.suffix else SpecError(f"{whose} is no picture that is read here; {ADVICE}")

    def end(self) -> None:
        """End the process, if there is one."""
        if self._child is not None:
            self._child.kill()
            self._child = None


def keep_pictures(studio: Studio, visitor: Visitor, pictures: Mapping[str, StoredPicture]) -> str:
    """Keep pictures that were read, for this visitor alone; returns by which id.

    Raises: Refusal as `Jobs.admit` and `Jobs.keep`.
    """
    with studio.jobs.receiving(KIND, visitor.id, visitor.role) as job:
        pack(studio, job, FILE, pictures, {})
        studio.jobs.keep(job)
    return job.id


def pack(
    studio: Studio,
    job: Job,
    name: str,
    pictures: Mapping[str, StoredPicture],
    others: Mapping[str, bytes],
) -> None:
    """Write an archive of that name into a job's folder: pictures, with a list of their keys and names, and others.

    Raises: Refusal 503 where it cannot be stored.
    """
    try:
        with zipfile.ZipFile(job.folder / name, "w") as packed:
            packed.writestr("pictures.json", json.dumps([[key, one.name] for key, one in pictures.items()]))
            for number, one in enumerate(pictures.values()):
                packed.writestr(f"pictures/{number}", one.data)
            for other, content in others.items():
                packed.writestr(other, content)
        studio.jobs.stored(job, (job.folder / name).stat().st_size)
    except OSError as error:
        raise Refusal(503, "disk", f"This cannot be stored ({error.strerror}); try again later.") from error


def kept_pictures(studio: Studio, visitor: Visitor, kept: str, what: str) -> dict[str, StoredPicture]:
    """The pictures that this visitor keeps by that id; `what` names them in messages.

    Raises: SpecError where there are none (any more); Refusal 503 where they cannot be read.
    """
    minutes = round(studio.settings.limits.keep_s / 60)
    gone = SpecError(f"{what} was kept for {minutes} minutes, and is removed by now; choose it again")
    if not JOB_ID.fullmatch(kept):
        raise gone
    try:
        job = studio.jobs.find(kept, visitor.id, KIND)
        with zipfile.ZipFile(job.folder / FILE) as packed:
            return unpacked(packed)
    except FileNotFoundError as error:
        raise gone from error
    except Refusal as error:
        if error.status == 404:
            raise gone from error
        raise


@contextmanager
def at_hand(pictures: Mapping[str, StoredPicture]) -> Iterator[dict[str, Path]]:
    """Pictures as files, by key, for as long as the body needs them; then nothing of them is left, in memory either."""
    with tempfile.TemporaryDirectory(prefix="moireid-pictures-") as folder:
        try:
            yield written(pictures, Path(folder) / "pictures")
        finally:
            forget_pictures()
