"""The whole frame of a report.  Each test states the wrong implementation that it would catch."""

from __future__ import annotations

import shutil
import struct
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from kit.numeric_films import FRAMES, TYPICAL, filmed
from moireid.badge import Badge
from moireid.question import KnownCamera
from moireid.verifier.decision.judge import judge
from moireid.verifier.fringes.signals import measure
from moireid.verifier.identity.decode import Identity
from moireid.verifier.report.film_frame import frame_picture, moment_to_show
from moireid.verifier.session.result import Report
from moireid.verifier.video import Film

SIZE = (320, 192)


@pytest.fixture(scope="module")
def counted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A film of 60 frames whose grey is their number times four; its upper left quarter is white."""
    path = tmp_path_factory.mktemp("counted") / "film.mp4"
    with av.open(str(path), "w") as made:
        stream = made.add_stream("libx264", rate=30, options={"crf": "4", "bf": "0", "threads": "2"})
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for number in range(60):
            grey = np.full((SIZE[1], SIZE[0], 3), 4 * number, np.uint8)
            grey[: SIZE[1] // 2, : SIZE[0] // 2] = 255
            frame = av.VideoFrame.from_ndarray(grey, format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, 30)
            made.mux(stream.encode(frame))
        made.mux(stream.encode())
    return path


@pytest.mark.parametrize("number", [0, 1, 30, 59])
@pytest.mark.parametrize("by_time", [True, False])
def test_the_frame_is_the_one_that_is_asked_for(counted: Path, number: int, by_time: bool) -> None:
    """Catches: the key frame before it, the frame after it, a time of another film's rate."""
    seen, turns = Film(counted).picture(number, number / 30 if by_time else None)
    assert seen.shape == (SIZE[1], SIZE[0], 3) and turns == 0
    assert float(seen[150:, 200:].mean()) == pytest.approx(4 * number, abs=1.6)


def test_a_phone_s_picture_stands_upright(counted: Path, tmp_path: Path) -> None:
    """Catches: a portrait that lies on its side, or on the other one; an outline that is not turned with it."""
    content = bytearray(counted.read_bytes())
    # The matrix of the track's header (ISO/IEC 14496-12), 40 bytes behind its name: a quarter turn clockwise.
    at = content.index(b"tkhd") + 44
    content[at : at + 36] = struct.pack(">9i", 0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30)
    path = tmp_path / "portrait.mp4"
    path.write_bytes(content)
    seen, turns = Film(path).picture(10)
    assert seen.shape[:2] == (SIZE[1], SIZE[0]) and turns == 3
    upright = np.rot90(seen, turns)
    assert float(upright[:100, -60:].mean()) > 250 > float(upright[:100, :60].mean())


def report_on(badge: Badge, path: Path, verdict: str = "accept") -> Report:
    """A report on numbers, said to be of this film."""
    track = filmed(badge, TYPICAL)
    track = replace(track, correlations=np.where(np.arange(FRAMES) == 30, 0.99, 0.5), image_px=(1920, 1080))
    measurement = measure(track, camera=KnownCamera(1450.0))
    invariant = replace(judge(measurement.gratings), verdict=verdict)
    film = Film(path).described()
    counts, timing = {"read": 60, "tracked": 60}, {"total_s": 1.0, "stages": {}}
    return Report(verdict, (), invariant, Identity("match", ()), film, counts, timing, (), track, measurement)


def test_the_badge_is_outlined_where_it_is(ada: Badge, counted: Path) -> None:
    """Catches: an outline of another frame or size; one that is mirrored with the measurement and not with the film."""
    report = report_on(ada, counted)
    moment = moment_to_show(report)
    corners = np.array([[60.0, 60.0], [120.0, 60.0], [120.0, 130.0], [60.0, 130.0]])
    coded = frame_picture(report, (*moment[:2], corners))
    assert coded is not None
    seen = cv2.imdecode(np.frombuffer(coded, np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1].astype(int)
    assert seen.shape == (SIZE[1], SIZE[0], 3)
    green = seen[:, :, 1] - seen[:, :, 0] > 60
    assert green[125:135, 90].any() and not green[:50].any() and not green[:, 140:].any()
    *_, mirrored = moment_to_show(replace(report, track=replace(report.track, mirrored=True)))
    assert moment[2] is not None and mirrored is not None
    assert mirrored[:, 0] == pytest.approx(1919 - moment[2][:, 0])


def test_another_film_is_never_shown(ada: Badge, counted: Path, tmp_path: Path, films: Path) -> None:
    """Catches: a picture of whatever lies at the path by then; a report that fails without its film."""
    path = tmp_path / "film.mp4"
    shutil.copy(counted, path)
    report = report_on(ada, path)
    assert frame_picture(report, moment_to_show(report)) is not None
    shutil.copy(films / "genuine_1.0m.mp4", path)
    assert frame_picture(report, moment_to_show(report)) is None
    path.unlink()
    assert frame_picture(report, moment_to_show(report)) is None
