"""One verify for `verify_cost.py`, in a process of its own that loads nothing else, so that its memory counts.

It is called with a JSON list: the film, the badge's file, the share of frames and of width that are used, and how often
it is repeated.  It prints costs, and the signals of the first grating, as JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from moireid.badge import load_badge
from moireid.verifier import Claim, Film, Frame, Verifier
from moireid.verifier.picture import Picture
from moireid.verifier.reasons import worst
from moireid.verifier.session.badge_session import reasons_of
from moireid.verifier.session.chapters import Chapter, invariant_of

#: Memory is noted after so many frames.
NOTE_FRAMES = 3600


def used(frames: Iterable[Frame], every: int, shrink: int) -> Iterator[Frame]:
    """Every so many frames, so many pixels across and down averaged to one; numbered as a film of them would be."""
    for frame in frames:
        if frame.index % every == 0:
            picture = frame.picture
            if shrink > 1:
                height, width = (side // shrink for side in picture.shape)
                whole = picture.whole[: height * shrink, : width * shrink]
                picture = Picture(
                    np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
                )
            yield Frame(frame.index // every, frame.time_s, picture)


def memory_mb(name: str) -> float:
    """This process's resident memory, MB: VmRSS, now; VmHWM, its peak.

    Not of `resource`: there a child's count begins with its parent's memory, and it knows the peak alone.
    """
    return int(Path("/proc/self/status").read_text().partition(f"{name}:")[2].split()[0]) / 1e3


def measured(film: Path, claim: Claim, every: int, shrink: int, runs: int) -> dict[str, Any]:
    """Least cost of some runs, peak of memory and its course, verdict and signals."""
    costs: list[tuple[float, float]] = []
    course: list[tuple[int, float]] = []
    chapters: list[Chapter] = []
    for _ in range(runs):
        cpu, clock = time.process_time(), time.perf_counter()
        verifier = Verifier(claim, running=False)
        for frame in used(Film(film).frames_ahead(), every, shrink):
            verifier.push(frame)
            if frame.index % NOTE_FRAMES == NOTE_FRAMES - 1:
                course.append((frame.index + 1, memory_mb("VmRSS")))
        chapters = verifier.finish()
        invariant, verdict = invariant_of(chapters), worst(list(reasons_of(chapters)))
        costs.append((time.process_time() - cpu, time.perf_counter() - clock))
    peak, begun = memory_mb("VmHWM"), time.process_time()
    frames = sum(1 for _ in Film(film).frames())
    return {
        "cpu_s": min(cpu for cpu, _ in costs),
        "wall_s": min(wall for _, wall in costs),
        "decode_s": time.process_time() - begun,
        "frames": frames,
        "peak_mb": peak,
        "course": course,
        "verdict": verdict,
        "gain": invariant.gain_ratio,
        "signals": signals(chapters[0]),
    }


def signals(chapter: Chapter) -> list[list[float]] | None:
    """Times, measured and predicted phase of the first grating; None where nothing was measured."""
    if chapter.measurement is None:
        return None
    signal = chapter.measurement.gratings[0]
    seen = np.isfinite(signal.phase_sd_rad)
    return [part[seen].tolist() for part in (signal.times_s, signal.measured_rad, signal.predicted_rad)]


if __name__ == "__main__":
    path, badge_path, frames_share, size_share, repeats = json.loads(sys.argv[1])
    badge = load_badge(Path(badge_path))
    print(json.dumps(measured(Path(path), Claim(badge, badge.id), frames_share, size_share, repeats)))
