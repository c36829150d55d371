"""Films of known truth for the verifier's bench, and how far what it measures is from that truth."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.simulate.filming import film, truth_path
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.simulate.truth import shown_phase_rad
from moireid.verifier.picture import Frame
from moireid.verifier.video import Film

Array = NDArray[np.float64]
PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
#: Print and sheet of their nominal size, because the truth file of a film is that of the badge as designed.
BUILD = Build(lens_offset_mm=0.13, twist_rad=math.radians(0.1))
FPS = 30.0


@dataclass(frozen=True)
class Kind:
    """What to film: motion by name, distance, and a forgery or None."""

    motion: str
    distance_m: float
    forge: str | None = None

    @property
    def name(self) -> str:
        """For tables."""
        return f"{self.forge or 'genuine'}, {self.motion}, {self.distance_m:g} m"


#: True films at 1 and 2 m, and forgeries that a rash setting could take for true.
KINDS = (
    Kind("sway", 1.0),
    Kind("handheld", 1.0),
    Kind("sway", 2.0),
    Kind("handheld", 2.0),
    Kind("sway", 2.0, "gain_low"),
    Kind("sway", 1.0, "wobble"),
)


@dataclass(frozen=True)
class FilmTruth:
    """Of each frame, (T,): time, phase of the fringes as shown, and the phase that the law says; of the film: the gain
    of the one over the other.
    """

    times_s: Array
    shown_rad: Array
    law_rad: Array

    @property
    def gain(self) -> float:
        """Regression of what is shown on the law: 1 for a true film."""
        law, shown = self.law_rad - self.law_rad.mean(), self.shown_rad - self.shown_rad.mean()
        return float(law @ shown) / float(law @ law)


@dataclass(frozen=True)
class DecodedFilm:
    """A film, decoded: its frames and their truth."""

    kind: Kind
    badge: Badge
    frames: list[Frame]
    truth: FilmTruth


def shoot(kind: Kind, frames: int, seed: int, folder: Path) -> DecodedFilm:
    """Film with sensor and H.264, and decode; all frames are held in memory, 2 MB each, so that nothing but the
    verifier runs while it is timed.
    """
    badge, camera = design_badge(Order("Bench", lens="50lpi"), PAYLOAD), Camera()
    video = folder / "film.mp4"
    motion = motion_named(kind.motion, distance_mm=1000 * kind.distance_m, seed=seed)
    film(
        Scene(badge, BUILD, camera), motion, video, frames=frames, fps=FPS, forge=kind.forge, seed=seed, overwrite=True
    )
    return DecodedFilm(kind, badge, list(Film(video).frames()), truth_of(badge, video))


def truth_of(badge: Badge, video: Path) -> FilmTruth:
    """The truth of a film, from the file next to it."""
    with truth_path(video).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    camera = np.array([[float(row[f"camera_{axis}_mm"]) for axis in "xyz"] for row in rows])
    law = [shown_phase_rad(Scene(badge), badge.gratings[0], place, place, np.zeros(2)) for place in camera]
    times, shown = (np.array([float(row[name]) for row in rows]) for name in ("time_s", "phase_rad"))
    return FilmTruth(times, shown, np.array(law))


def phase_error_rad(times_s: Array, phase_rad: Array, true_s: Array, true_rad: Array) -> float | None:
    """Root mean square of a phase less the true one, means removed; None where fewer than two frames have a phase.

    Convention: over all frames of the film from the first to the last used one; between used frames the phase is
    interpolated, so that motion lost with skipped frames counts as error.
    """
    inside = (true_s >= times_s.min(initial=math.inf) - 1e-9) & (true_s <= times_s.max(initial=-math.inf) + 1e-9)
    if inside.sum() < 2:
        return None
    apart = np.interp(true_s[inside], times_s, phase_rad) - true_rad[inside]
    return float(apart.std())
