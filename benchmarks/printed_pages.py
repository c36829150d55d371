"""Pages that a printer fed too far or too short: run `.venv/bin/python benchmarks/printed_pages.py`.

True films are tracked once: two of an outside simulator (tests/data/films) and twelve of our own, from 1 m.  Then each
is judged as if its page had been higher or lower, which a track shows exactly: its homographies then hold for other
places of the page.  Printed is what becomes of the films, and how far gain and aspect are off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from moireid.badge import load_badge
from moireid.designer import Request, design_badge
from moireid.simulate import Build, Scene, camera_named, motion_named
from moireid.verifier import Claim, verify
from moireid.verifier.decision.judge import judge_signals
from moireid.verifier.fringes.signals import measure
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.track import Track
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script, temporary_film

FILMS = Path(__file__).resolve().parent.parent / "tests" / "data" / "films"
OUTSIDE = ("genuine_1.0m", "genuine_2.0m")
CAMERAS, MOTIONS, SEEDS = ("phone", "webcam"), ("sway", "handheld", "both"), (1, 2)
FRAMES, FPS, DISTANCE_MM = 150, 30, 1000.0
#: Logarithms of the page's height over the design's.
ASPECTS = (-0.005, -0.002, 0.0, 0.002, 0.005)


def tracks() -> list[Track]:
    """All films, tracked."""
    badge = load_badge(FILMS / "badge.json")
    found = [verify(FILMS / f"{name}.mp4", Claim(badge)).track for name in OUTSIDE]
    own = design_badge(Request("Bench"), bytes.fromhex("0f5ac3962d784be1"))
    for camera, motion, seed in product(CAMERAS, MOTIONS, SEEDS):
        scene = Scene(own, replace(Build.typical(seed), print_aspect=1.0), camera_named(camera))
        course = motion_named(motion, distance_mm=DISTANCE_MM, seed=seed)
        with temporary_film(scene, course, frames=FRAMES, fps=FPS, seed=seed) as video:
            found.append(verify(video, Claim(own)).track)
    return found


def fed(track: Track, aspect: float) -> Track:
    """The track of a page that is higher by `aspect`, about its middle, as it would have been seen."""
    middle = float(marker_corners_mm(track.badge.markers)[..., 1].mean())
    place = np.array([[1, 0, 0], [0, np.exp(aspect), middle * (1 - np.exp(aspect))], [0, 0, 1]])
    return replace(track, homographies=track.homographies @ place)


def rows(wish: Wish) -> Iterator[Row]:
    """One row an aspect."""
    films = tracks()
    for aspect in ASPECTS:
        measured = [measure(fed(track, aspect)) for track in films]
        found = [judge_signals(one.gratings) for one in measured]
        verdicts = [one.verdict for one in found]
        yield {
            "aspect": aspect,
            **{verdict: verdicts.count(verdict) for verdict in ("accept", "inconclusive", "reject")},
            "|gain - 1|": float(np.median([abs((one.gain_ratio or np.nan) - 1) for one in found])),
            "error bar": float(np.median([one.gain_sd or np.nan for one in found])),
            "aspect off": float(np.median([abs(np.log(one.camera.print_aspect) - aspect) for one in measured])),
        }


COLUMNS = {"aspect": ">8+.1%", "accept": ">8", "inconclusive": ">13", "reject": ">8", "|gain - 1|": ">11.3f"}
COLUMNS |= {"error bar": ">10.3f", "aspect off": ">11.3%"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
