"""Parts of the judge's process, and this machine's cameras.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from kit.coded_films import written
from kit.damaging import Part, joined, zeroed
from moireid.badge import Badge
from moireid.errors import MediaError
from moireid.question import Question
from moireid.verifier.picture import Picture
from moireid.verifier.reasons import Reason
from moireid_studio.challenge.stream import StreamCheck
from moireid_studio.watch import cameras
from moireid_studio.watch.order import Patience
from moireid_studio.watch.readers import (
    AHEAD,
    GrowingFile,
    Inbox,
    PipeBytes,
    TimedPicture,
    pictures,
)
from moireid_studio.watch.source import source_of


def taken(number: int) -> TimedPicture:
    return TimedPicture(Picture(np.zeros((2, 2), np.uint8)), float(number), 0.0)


def test_a_live_source_loses_its_oldest_pictures_and_a_film_none() -> None:
    """Catches: a delay that grows where pictures come faster than they are judged; a film with holes."""
    inbox = Inbox(waits=False)
    for k in range(AHEAD + 3):
        inbox.put_picture(taken(k))
    inbox.put("message")
    assert inbox.lost == 3 and inbox.get(1) == "message"
    assert [inbox.get(1).claimed_s for _ in range(AHEAD)] == [float(k) for k in range(3, AHEAD + 3)]
    assert inbox.get(0.01) is None
    film, done = Inbox(waits=True), threading.Event()

    def decode() -> None:
        for k in range(AHEAD + 3):
            film.put_picture(taken(k))
        film.put_last("end")
        done.set()

    threading.Thread(target=decode, daemon=True).start()
    assert not done.wait(0.1)
    assert [film.get(1).claimed_s for _ in range(AHEAD + 3)] == [float(k) for k in range(AHEAD + 3)]
    assert film.get(1) == "end" and film.lost == 0


def test_a_film_of_two_tracks_is_refused_and_one_with_damage_read_past_it(tmp_path: Path) -> None:
    """Catches: the first of two tracks judged, where players show the other; a stream that ends at a lost packet; wrong
    pictures after it, up to the next key picture, judged.
    """
    noise = np.random.default_rng(1).integers(0, 255, (30, 288, 384), np.uint8)
    film = written(tmp_path / "film.mkv", list(noise), "libx264", "yuv420p")
    taken: list[TimedPicture] = []
    inbox: Any = SimpleNamespace(put_picture=taken.append)
    piped = PipeBytes(lambda wish: None)
    patience = Patience(open_s=1.0, stall_s=1.0, grown_s=0.1)
    two = joined([Part(film), Part(film, 1)], tmp_path / "two.mkv")
    with pytest.raises(MediaError, match="2 video tracks, and players differ"):
        pictures(source_of(str(two)), piped, inbox, patience)
    assert not taken
    pictures(source_of(str(zeroed(film, tmp_path / "zeroed.mkv", 20))), piped, inbox, patience)
    assert [round(one.claimed_s * 30) for one in taken] == list(range(20))


def test_a_file_is_read_on_until_it_grows_no_more(tmp_path: Path) -> None:
    """Catches: an end at the first stop; a wait for a file that was not written to for long."""
    path = tmp_path / "film.ts"
    path.write_bytes(b"a")
    reader = GrowingFile(path, 0.6)
    assert reader.read(10) == b"a"
    threading.Timer(0.3, lambda: path.open("ab").write(b"b")).start()
    assert reader.read(10) == b"b"
    assert reader.read(10) == b"" and reader.read(10) == b""
    os.utime(path, (0, 0))
    old = GrowingFile(path, 60.0)
    assert old.read(10) + old.read(10) == b"ab"


def test_a_stream_of_which_nothing_passes_is_not_accepted(ada: Badge, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a stream's verdict by a rule of its own, which takes notes alone for an acceptance."""
    check = StreamCheck(Question(ada, ada.id))
    note = Reason("challenge", "note", None, None, "", "No prompts.")
    monkeypatch.setattr(StreamCheck, "_weighed", lambda self, reasons, chapters: (note,))
    document = check.finish()
    assert (document["verdict"], document["level"]) == ("inconclusive", None)


class FakeCamera:
    """A camera of three pictures that gives times, in the place of OpenCV's."""

    def __init__(self, number: int) -> None:
        self.number, self.count, self.released = number, 0, False

    def isOpened(self) -> bool:
        return self.number == 0

    def set(self, *what: Any) -> None:
        pass

    def get(self, what: int) -> float:
        return 1000.0 * self.count

    def read(self) -> tuple[bool, Any]:
        self.count += 1
        return (self.count <= 3, np.full((4, 6, 3), 10 * self.count, np.uint8) if self.count <= 3 else None)

    def release(self) -> None:
        self.released = True


def test_a_camera_gives_grey_pictures_at_its_own_times(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: times of arrival where the camera gives its own; a camera that is gone and read on; colours."""
    monkeypatch.setattr(cv2, "VideoCapture", FakeCamera)
    monkeypatch.setattr(time, "sleep", lambda seconds: None)
    shots = list(cameras.shots_of(0))
    assert [one.claimed_s for one in shots] == [1.0, 2.0, 3.0] and shots[0].size == (4, 6)
    assert [set(one.luma) for one in shots] == [{10}, {20}, {30}]
    assert cameras.taken_s(0.0, 5.0) == 5.0 and cameras.taken_s(-1.0, 5.0) == 5.0
    with pytest.raises(MediaError, match="camera 1 cannot be opened"):
        list(cameras.shots_of(1))
