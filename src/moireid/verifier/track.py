"""The pass over the film: find the page, register it, read its profiles.  One frame in memory at a time.

What is kept of a frame is its homography and its strips' profiles, 3 to 6 kB; a film of ten minutes keeps 0.1 GB.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.markers import MarkerFinder
from moireid.verifier.register import PageRegistrar
from moireid.verifier.strips import ProfileReader, Strip
from moireid.verifier.video import Film

Array = NDArray[np.float64]
Progress = Callable[[int, int | None], None]


@dataclass(frozen=True)
class Track:
    """The badge over the film: T tracked frames of the `frames_read` that were read.

    homographies (T, 3, 3) page mm -> px; profiles (T, S, N) counts; correlations (T,) of picture and print.
    """

    frames_read: int
    frame_numbers: NDArray[np.int64]
    times_s: Array
    homographies: Array
    correlations: Array
    profiles: NDArray[np.float32]
    strips: tuple[Strip, ...]
    image_px: tuple[int, int]
    stages_s: dict[str, float] = field(default_factory=dict)

    @property
    def tracked(self) -> int:
        """Number of frames in which the badge was found and registered."""
        return len(self.times_s)


def track_badge(film: Film, badge: Badge, progress: Progress | None = None) -> Track:
    """Follow the badge through the film.

    Parameters: progress: called with frames read and frames expected, if the file says.
    Convention: homographies as `MarkerFinder.find`; only the badge's layout is looked at, not its pitches or id.
    Returns: Track, which may be empty.
    Raises: MediaError where the film breaks off.
    Source: `markers`, `register` and `strips`, in that order in each frame.
    """
    finder, registrar, reader = MarkerFinder(badge.markers), PageRegistrar(badge.markers), ProfileReader(badge)
    numbers, times, homographies, correlations, profiles = [], [], [], [], []
    stages = dict.fromkeys(("decode", "find", "register", "profiles"), 0.0)
    clock = time.perf_counter()

    def lap(stage: str) -> None:
        nonlocal clock
        now = time.perf_counter()
        stages[stage] += now - clock
        clock = now

    read = 0
    for frame in film.frames():
        read += 1
        lap("decode")
        start = finder.find(frame.luma)
        lap("find")
        registration = registrar.register(frame.luma, start) if start is not None else None
        finder.follow(registration.homography if registration else None)
        lap("register")
        if registration:
            numbers.append(frame.index)
            times.append(frame.time_s)
            homographies.append(registration.homography)
            correlations.append(registration.correlation)
            profiles.append(reader.read(frame.luma, registration.homography))
            lap("profiles")
        if progress:
            progress(read, film.frames_expected)
    shape = (0, len(reader.strips), reader.samples)
    return Track(
        frames_read=read,
        frame_numbers=np.array(numbers, np.int64),
        times_s=np.array(times, float),
        homographies=np.array(homographies, float).reshape(-1, 3, 3),
        correlations=np.array(correlations, float),
        profiles=np.array(profiles, np.float32).reshape(len(profiles) or 0, *shape[1:]),
        strips=tuple(reader.strips),
        image_px=(film.width, film.height),
        stages_s=stages,
    )
