"""Streams for the tests of `watch`: films of the project in the containers that are sent."""

from __future__ import annotations

import threading
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av

from kit.places import FILMS
from moireid.badge import Badge, load_badge
from moireid.verifier import Question
from moireid_studio.watch.order import Patience, WatchOrder
from moireid_studio.watch.source import source_of
from moireid_studio.watch.watching import watch

SIZE, FPS = (1280, 720), 30
QUICK = Patience(open_s=8.0, stall_s=2.0, grown_s=1.0)


def pictures(name: str = "genuine_1.0m", size: tuple[int, int] = SIZE) -> list[av.VideoFrame]:
    """Every second picture of a film of 60 a second."""
    with av.open(str(FILMS / f"{name}.mp4")) as film:
        return [one.reformat(*size, "yuv420p") for k, one in enumerate(film.decode(video=0)) if k % 2 == 0]


def write_stream(
    path: Path, shots: list[av.VideoFrame], *, kind: str = "mpegts", fps: int = FPS, **options: str
) -> Path:
    """Pictures as H.264, with a key picture a second, so that it can be cut."""
    with av.open(str(path), "w", format=kind, options=options) as out:
        coding = {"crf": "18", "preset": "ultrafast", "g": str(fps), "bf": "0", "threads": "2"}
        stream = out.add_stream("libx264", rate=fps, options=coding)
        stream.width, stream.height, stream.pix_fmt = shots[0].width, shots[0].height, "yuv420p"
        for k, shot in enumerate(shots):
            shot.pts, shot.time_base, shot.pict_type = k, Fraction(1, fps), 0
            out.mux(stream.encode(shot))
        out.mux(stream.encode())
    return path


def prototype() -> Badge:
    return load_badge(FILMS / "badge.json")


def watched(
    source: str,
    *,
    notify: Callable[[dict[str, Any]], None] = lambda event: None,
    stop: threading.Event | None = None,
    patience: Patience = QUICK,
    seconds: float = 60.0,
    **more: Any,
) -> dict[str, Any]:
    """The verdict's event on a source, held against the board of the films."""
    order = WatchOrder(source_of(source), Question(prototype(), **more), patience=patience)
    return watch(order, seconds, stop or threading.Event(), notify)
