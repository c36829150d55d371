"""What a film shows of the badge, frame by frame: the truth, or a forgery of any kind.

False trajectories of the whole badge are those of `trajectories`.  Two more groups are made here.

Flat forgeries are a printed photograph of the badge, and a film of the badge replayed on a screen.  In a scene with a
light, the forger's picture already has its bands and glare.  When it is filmed it shines evenly, as the page around it
does, so that no light counts twice.  Both show one picture of the whole badge as seen from one place, straightened, at
true size and with the true markers.  The forger is a good one: tones are exact, the picture is flat, and it has no
gloss.

The screen plays a film that was straightened by its markers.  So the badge stays still on the screen, and its fringes
move with the replayed camera, whose motion has the true spread.  Each frame is held for 1/30 s.  Left out are the
screen's glow, its black level, and its pixels, which are far finer than a camera's pixel at such distances.  If the
filming camera stays still, the screen shows a true film, and no law of motion can find the forgery.

Forgeries whose parts disagree are patches that each have their own clock, and fringes as generated pictures show them.
Their field holds, for each part of the board, the parallax coordinate that it shows less the true one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.lenticule import view_law
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.cameras import Camera
from moireid.simulate.forgeries.trajectories import KINDS, TRAJECTORIES, false_camera, random_walk
from moireid.simulate.motion import Motion, Poses
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
#: Fineness of the photograph: four pixels or more to a lens, so it shows the lenses themselves.
PHOTO_PX_PER_MM = 8.0
#: Fineness of the replayed film: what a film of 2160 rows sees from 1 m.
SCREEN_PX_PER_MM = 3.0
SCREEN_FPS = 30.0


def held_frames(count: int, fps: float) -> NDArray[np.int64]:
    """Which frame the screen shows at each of a film's frames (T,): the last that came due at `SCREEN_FPS`.

    In a film with fewer frames a second than the screen, each frame shows another one of the screen.
    """
    if fps <= SCREEN_FPS:
        return np.arange(count)
    due = np.floor(np.arange(count) / fps * SCREEN_FPS + 1e-6) / SCREEN_FPS
    return np.floor(due * fps + 1e-6).astype(np.int64)


class SquaredUp:
    """Straightened pictures of the board as seen from a place: what a forger prints, or plays on a screen."""

    def __init__(self, scene: Scene, per_mm: float) -> None:
        self._scene = replace(scene, hidden_mm=None)
        half = scene.printed_half_mm
        columns = max(round(2 * half[0] * per_mm), 2)
        self._per_mm = columns / (2 * half[0])
        self._size = (math.ceil(2 * half[1] * self._per_mm), columns)
        self._renderer = AnalyticRenderer(self._scene)

    def picture(self, camera_mm: Array) -> NDArray[np.float32]:
        """Radiance (rows, columns) over the whole board as seen from `camera_mm` (3,)."""
        half = self._scene.printed_half_mm
        # A camera that faces the board squarely sees it at one scale; its place says where the view axis falls.
        axis = [(half[k] + float(camera_mm[k])) * self._per_mm - 0.5 for k in (0, 1)]
        focal = self._per_mm * abs(float(camera_mm[2]))
        camera = Camera(self._size[1], self._size[0], focal, shutter_s=0.0, principal_px=(axis[0], axis[1]))
        self._renderer.scene = replace(self._scene, camera=camera)
        pose = Poses(camera_mm[None], np.eye(3)[None])
        seen = self._renderer.render(Instant(pose, pose, camera_mm))
        picture = np.full(self._size, self._scene.paper, np.float32)
        if seen is not None:
            rows, columns = seen.radiance.shape
            picture[seen.top : seen.top + rows, seen.left : seen.left + columns] = seen.radiance
        return picture


#: Patches down and across the board.  The truth file holds the phase of the lower right patch, which has the centre.
PATCHES = (4, 4)
#: Each patch shows the true motion at another time, at most this far off.
CLOCK_S = 1.5
#: Steps of the generative field, mm: 0.03 rad of phase at its widest.
STEP_MM = 1.0
#: Spread of the generative pitch, as a share of the beat frequency.
PITCH_WANDER = 0.1


def parallax(camera_mm: Array) -> Array:
    """Parallax coordinates (..., 2) of camera centres (..., 3)."""
    return np.asarray(camera_mm[..., :2] / np.abs(camera_mm[..., 2:]))


class OwnClocks:
    """Each patch of the board shows the true motion at its own time, earlier or later by up to `CLOCK_S`."""

    def __init__(self, motion: Motion, seed: int) -> None:
        self._motion = motion
        self._late_s = np.random.default_rng(seed).uniform(-CLOCK_S, CLOCK_S, PATCHES)

    def at(self, time_s: float) -> Array:
        """The field (rows, columns, 2) at that time."""
        clocks = np.concatenate([[time_s], time_s + self._late_s.ravel()])
        shown = parallax(self._motion(clocks).camera_mm)
        return np.asarray((shown[1:] - shown[0]).reshape(*PATCHES, 2))


class Generative:
    """A true first frame; then phase and pitch wander, as in a film whose pictures are generated one by one.

    The phase wanders with the true motion's own spread, at random; the beat's frequency wanders by `PITCH_WANDER`.
    Convention: the wandering phase is in the shown place, so the field holds only the change of pitch.
    """

    def __init__(self, badge: Badge, camera_mm: Array, fps: float, seed: int) -> None:
        true = parallax(camera_mm)
        walk = random_walk(len(true), fps, seed)
        walk = true[0] + true.std(axis=0) * (walk - walk[0])
        distance = np.abs(camera_mm[:, 2:])
        self.camera_mm = np.column_stack([walk * distance, camera_mm[:, 2]])
        stretch = random_walk(len(true), fps, seed + 1)
        self._stretch = PITCH_WANDER * (stretch - stretch[0])
        pitch, lens = badge.gratings[0].pitch_mm, badge.lens
        # A stretch s of the beat adds s * (1/p_r - 1/p_f) cycles to each mm; in parallax that is p_r / gap a cycle.
        gap = view_law(lens, pitch).effective_gap_mm(pitch)
        self._per_mm = (1 / pitch - 1 / lens.pitch_mm) * pitch / gap
        x0, y0, x1, y1 = badge.outline_mm
        # With an odd number of steps one lies at the board's centre, where a change of pitch changes nothing.
        self._size = 2 * math.ceil((y1 - y0) / STEP_MM / 2) + 1, 2 * math.ceil((x1 - x0) / STEP_MM / 2) + 1
        self._half = (x1 - x0) / 2, (y1 - y0) / 2

    def at(self, frame: int) -> Array:
        """The field (rows, columns, 2) of that frame."""
        rows, columns = self._size
        x = ((np.arange(columns) + 0.5) / columns * 2 - 1) * self._half[0]
        y = ((np.arange(rows) + 0.5) / rows * 2 - 1) * self._half[1]
        slope = -self._per_mm * self._stretch[frame]
        return np.stack(np.broadcast_arrays(slope[0] * x, slope[1] * y[:, None]), axis=-1)


#: A false place this near the true one, mm, at every frame shows the same fringes, within 0.001 rad from 0.5 m on.
SAME_MM = 0.01


@dataclass(frozen=True)
class ShownViews:
    """camera_mm (T, 3): from where the fringes are shown; sight_mm (T, 3): from where the sheet above the page is seen.

    The two differ where only the fringes are forged.  A flat picture has both from the place where it was taken.
    field, picture: of a frame, as in `scene.Instant`.
    """

    camera_mm: Array
    sight_mm: Array
    field: Callable[[int], Array | None] = lambda frame: None
    picture: Callable[[int], NDArray[np.float32] | None] = lambda frame: None

    def instant(self, frame: int, rows: tuple[Poses, Poses, Poses]) -> Instant:
        """A frame to render, of the poses of first, middle and last row (T each) over its exposure."""
        # True fringes move with the camera while it is open; forged ones do not move within a frame.
        place = rows[1].camera_mm if self.camera_mm is self.sight_mm else self.camera_mm[frame]
        return Instant(rows[0], rows[2], place, self.field(frame), self.picture(frame))


def shown_in(kind: str | None, scene: Scene, motion: Motion, camera_mm: Array, fps: float, seed: int) -> ShownViews:
    """What is shown in a film.

    Parameters: kind: one of `trajectories.KINDS`, None for a true film; camera_mm (T, 3): the true centres.
    Convention: the board frame of `motion`.
    Raises: SpecError for an unknown kind, and for a false trajectory that equals the true one.
    Source: `trajectories`, and this module's docstring.
    """
    if kind is None:
        return ShownViews(camera_mm, camera_mm)
    if kind in TRAJECTORIES:
        false_mm = false_camera(kind, camera_mm, fps, seed)
        # A false trajectory has the true one's spread; if that is zero, a film labelled as forged would show the truth.
        if np.abs(false_mm - camera_mm).max() < SAME_MM:
            raise SpecError(
                f"a {kind} forgery of this motion shows the true fringes, as the camera does not move enough; "
                "choose another motion, a longer film, or another forgery"
            )
        return ShownViews(false_mm, camera_mm)
    if kind == "patchy":
        clocks = OwnClocks(motion, seed)
        return ShownViews(camera_mm, camera_mm, field=lambda frame: clocks.at(frame / fps))
    if kind == "generative":
        made_up = Generative(scene.badge, camera_mm, fps, seed)
        return ShownViews(made_up.camera_mm, camera_mm, field=made_up.at)
    if kind == "photo":
        place = np.array([0.0, 0.0, camera_mm[0, 2]])
        photograph = SquaredUp(scene, PHOTO_PX_PER_MM).picture(place)
        held = np.broadcast_to(place, camera_mm.shape)
        return ShownViews(held, held, picture=lambda frame: photograph)
    if kind == "screen":
        held = false_camera("splice", camera_mm, fps, seed)[held_frames(len(camera_mm), fps)]
        return ShownViews(held, held, picture=_Replay(SquaredUp(scene, SCREEN_PX_PER_MM), held).at)
    raise SpecError(f"forgery {kind!r} is not known; choose one of {', '.join(KINDS)}")


class _Replay:
    """The screen's picture at each frame; a picture that is held is computed once."""

    def __init__(self, screen: SquaredUp, held_mm: Array) -> None:
        self._screen, self._held = screen, held_mm
        # No place equals NaN, so the first picture is always computed.
        self._place: Array = np.full(3, np.nan)
        self._picture = np.empty((0, 0), np.float32)

    def at(self, frame: int) -> NDArray[np.float32]:
        """Radiance (rows, columns) over the board."""
        place = self._held[frame]
        if not np.array_equal(place, self._place):
            self._place, self._picture = place, self._screen.picture(place)
        return self._picture
