"""Films whose times start anew, where recordings were joined.  Each test states what it catches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.verifier import Film, Frame, Question, Verifier, verify
from moireid.verifier.session.chapters import invariant_of

FPS = 15


def every_second(film: Path) -> Iterator[Frame]:
    """Every second frame of a film of 30 frames a second: 120 of them."""
    frames = (frame for frame in Film(film).frames() if frame.index % 2 == 0)
    return (Frame(k, k / FPS, frame.picture) for k, frame in enumerate(frames))


def judged(film: Path, badge: Badge, told_s: Callable[[float], float]) -> Verifier:
    """A film with changed timestamps, judged to its end."""
    verifier = Verifier(Question(badge), running=False)
    for frame in every_second(film):
        verifier.push(frame.at(told_s(frame.time_s)))
    verifier.finish()
    return verifier


@pytest.fixture(scope="module")
def joined(films: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A true film cut in two pieces of a transport stream, each with times of its own, whose bytes are joined.

    The film has one key frame alone, so the pieces are coded anew.
    """
    folder = tmp_path_factory.mktemp("joined")
    pictures = [frame.luma for frame in every_second(films / "genuine_1.0m.mp4")]
    for name, part in (("first.ts", pictures[:60]), ("second.ts", pictures[60:])):
        with av.open(str(folder / name), "w", format="mpegts") as container:
            stream = container.add_stream("libx264", rate=FPS)
            stream.height, stream.width = part[0].shape
            stream.options = {"crf": "12", "preset": "ultrafast", "threads": "2"}
            for number, picture in enumerate(part):
                frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
                frame.pts, frame.time_base = number, Fraction(1, FPS)
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
    path = folder / "joined.ts"
    path.write_bytes((folder / "first.ts").read_bytes() + (folder / "second.ts").read_bytes())
    return path


@pytest.mark.slow
def test_two_pieces_of_a_transport_stream_are_accepted(joined: Path, prototype: Badge):
    """Catches: a course smoothed from the end of one piece to the start of the other, by which this film was rejected
    (correlation 0.6); segments that run backwards.
    """
    times = [frame.time_s for frame in Film(joined).frames()]
    assert len(times) == 120 and np.diff(times).min() < -3.0
    report = verify(joined, Question(prototype))
    assert report.verdict == "accept" and report.invariant.correlation > 0.999
    assert report.invariant.gain_ratio == pytest.approx(1.0, abs=0.02)
    told = next(reason for reason in report.reasons if reason.code == "times")
    assert (told.level, told.measured) == ("note", 1.0)
    starts = [segment.start_s for segment in report.segments]
    assert starts == sorted(starts) and report.segments[-1].end_s > 8.0
    assert np.all(np.diff(report.track.times_s) > 0)


@pytest.mark.slow
def test_times_that_start_anew_hide_no_drift(films: Path, prototype: Badge):
    """Catches: chapters of two seconds for whoever sets the times back, in which a slow drift is no evidence."""
    verifier = judged(films / "forged_drift_1.0m.mp4", prototype, lambda time_s: time_s % 2.0)
    assert [reason.measured for reason in verifier.restarts if reason.code == "times"] == [3.0]
    assert invariant_of(verifier.chapters).verdict == "reject"


@pytest.mark.parametrize("time_s", [float("nan"), float("inf"), -float("inf")])
def test_a_time_that_is_none_is_refused(prototype: Badge, time_s: float):
    """Catches: nan, to which no time is earlier or later, let into the film."""
    verifier = Verifier(Question(prototype), running=False)
    with pytest.raises(SpecError, match=f"time {time_s}"):
        verifier.push(Frame(0, time_s, np.zeros((90, 160), np.uint8)))
