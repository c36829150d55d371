"""Where the camera is: named motions, two of them measured, and CSV files.

Convention: board frame in mm, origin at the board's centre, x right, y down, z into the board; the camera looks along
its own z, x right, y down (OpenCV).  `rotation` turns board vectors into camera vectors.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError, SpecError
from moireid.files import MOST_TABLE_BYTES, AnyPath, as_path, read_regular
from moireid.simulate.phone_walk import PHONE_WALK, around_badge, fast_turns_rad, to_and_fro_s
from moireid.simulate.turns import continuous, from_quaternions, from_vectors, from_yxz, spline

Array = NDArray[np.float64]
COLUMNS = ("t_s", "x_mm", "y_mm", "z_mm", "qx", "qy", "qz", "qw")
MEASURED_RUN = "data/handheld_tum_fr1_xyz.csv"


@dataclass(frozen=True)
class Poses:
    """Where the camera is, at T times.

    Parameters
    ----------
    camera_mm : array (T, 3)
        Camera centres in the board frame, mm; z is negative before the badge.
    rotation : array (T, 3, 3)
        Turns board vectors into camera vectors.

    Notes
    -----
    Convention: board frame with its origin at the board's centre, x right, y down, z into the board.  The camera looks
    along its own z, x right, y down (OpenCV).
    """

    camera_mm: Array
    rotation: Array

    def one(self, k: int) -> Poses:
        """The pose at place k alone."""
        return Poses(self.camera_mm[k : k + 1], self.rotation[k : k + 1])


Motion = Callable[[Array], Poses]
"""The camera's trajectory: from times (T,), s, to the poses at these times."""


def motion_named(name: AnyPath, *, distance_mm: float, seed: int) -> Motion:
    """Give a motion by name, or read one from a CSV file.

    Parameters
    ----------
    name : str or Path
        One of `NAMED`, or the path of a CSV file.
    distance_mm : float
        Mean distance from the badge, mm.
    seed : int
        Of what is random in it.

    Returns
    -------
    Motion
        From times (T,) in seconds to `Poses`.

    Raises
    ------
    SpecError
        Where there is neither such a name nor such a file.
    MediaError
        Where the file is no motion.

    Notes
    -----
    Convention: as `Poses`.
    Source: each motion's own docstring; "handheld" replays a measured run of the TUM RGB-D data set, "walk" one of
    ARKit-Data-Logger.
    """
    if isinstance(name, str) and name in NAMED:
        return NAMED[name](distance_mm, seed)
    path = as_path(name)
    if path.suffix.lower() != ".csv":
        raise SpecError(f"motion {name!r} is not known; give one of {', '.join(NAMED)}, or a .csv file")
    return from_csv(path, distance_mm)


def static(distance_mm: float, seed: int) -> Motion:
    """A camera on a tripod, straight in front; nothing moves."""

    def poses(times_s: Array) -> Poses:
        camera = np.tile([0.0, 0.0, -distance_mm], (len(times_s), 1))
        return Poses(camera, np.tile(np.eye(3), (len(times_s), 1, 1)))

    return poses


def linear(distance_mm: float, seed: int) -> Motion:
    """Half a metre in a straight line in two seconds and back, with small random turns.

    Source: the published rendering experiment (Qing et al. 2026); turning back is ours, for films of any length.
    """
    tremor = _tremor(seed, count=3, amplitude=math.radians(0.5), band_hz=(0.3, 4.0))

    def poses(times_s: Array) -> Poses:
        place = _to_and_fro(times_s)
        camera = np.column_stack([250.0 * place, np.zeros_like(place), np.full_like(place, -distance_mm)])
        return _aimed(camera, tremor(times_s))

    return poses


def sway(distance_mm: float, seed: int) -> Motion:
    """A wearer shifting from foot to foot before a camera on a tripod: sideways and yaw together, as a torso moves."""
    place = _tremor(seed, count=3, amplitude=1.0, band_hz=(0.15, 0.6))
    turn = _tremor(seed + 1, count=3, amplitude=math.radians(1.5), band_hz=(0.2, 1.5))

    def poses(times_s: Array) -> Poses:
        beat = np.sin(2 * math.pi * 0.31 * times_s)
        moved = place(times_s)
        badge = np.column_stack([120.0 * beat, 8.0 * moved[:, 1], 25.0 * moved[:, 2]])
        yaw = np.radians(9.0) * np.sin(2 * math.pi * 0.31 * times_s + 0.5)
        wobble = turn(times_s)
        board_to_camera = from_yxz(np.column_stack([yaw + wobble[:, 0], wobble[:, 1], wobble[:, 2]]))
        shift = badge + np.array([0.0, 0.0, distance_mm])
        return Poses(-_turned_back(board_to_camera, shift), board_to_camera)

    return poses


def roll(distance_mm: float, seed: int) -> Motion:
    """In-plane rotation: the linear path while the camera turns about its view axis, 25 degrees either way.

    Source: the linear path's; how far and how fast a hand turns a phone (0.4 Hz) is ours.
    """
    path = linear(distance_mm, seed)

    def poses(times_s: Array) -> Poses:
        straight = path(times_s)
        turn = np.zeros((len(times_s), 3))
        turn[:, 2] = math.radians(25.0) * np.sin(2 * math.pi * 0.4 * times_s)
        return Poses(straight.camera_mm, from_vectors(turn) @ straight.rotation)

    return poses


def oblique(distance_mm: float, seed: int) -> Motion:
    """The linear path seen from the side: the badge faces 45 degrees away from the middle of the path.

    Convention: the camera stays on the side of +x, at the same distance from the badge as the linear path.
    """
    path, aside = linear(distance_mm, seed), from_yxz(np.array([[-math.pi / 4, 0.0, 0.0]]))[0]

    def poses(times_s: Array) -> Poses:
        straight = path(times_s)
        return Poses(straight.camera_mm @ aside.T, straight.rotation @ aside.T)

    return poses


def tumble(distance_mm: float, seed: int) -> Motion:
    """Compound rotation: a badge held in the hand turns about all three of its axes at once before a still camera.

    Convention: 14, 10 and 20 degrees about y, x and z, at rates that do not repeat within a minute; a tremor on top.
    """
    tremor = _tremor(seed, count=6, amplitude=1.0, band_hz=(0.3, 4.0))
    swing, rate_hz, start = np.radians([14.0, 10.0, 20.0]), np.array([0.37, 0.29, 0.23]), np.array([0.0, 0.9, 2.1])

    def poses(times_s: Array) -> Poses:
        shake = tremor(times_s)
        turns = swing * np.sin(2 * math.pi * rate_hz * times_s[:, None] + start) + math.radians(0.3) * shake[:, :3]
        board_to_camera = from_yxz(turns)
        shift = np.array([0.0, 0.0, distance_mm]) + 4.0 * shake[:, 3:]
        return Poses(-_turned_back(board_to_camera, shift), board_to_camera)

    return poses


def circle(distance_mm: float, seed: int) -> Motion:
    """A circle of 120 mm round the badge's axis, three seconds a turn: as much sideways as up and down.

    Both axes of a two-axis badge are excited alike, a quarter of a turn apart, so one cannot replace the other.
    """
    tremor = _tremor(seed, count=3, amplitude=math.radians(0.5), band_hz=(0.3, 4.0))

    def poses(times_s: Array) -> Poses:
        angle = 2 * math.pi * times_s / 3.0
        camera = np.column_stack([120 * np.cos(angle), 120 * np.sin(angle), np.full_like(angle, -distance_mm)])
        return _aimed(camera, tremor(times_s))

    return poses


def board(distance_mm: float, seed: int) -> Motion:
    """The board moves as the linear path's camera does, half a metre to and fro, before a camera on a tripod.

    Source: the second of the published ways to film (Qing et al. 2026); a hand's tremor of 0.5 degrees is ours.
    """
    tremor = _tremor(seed, count=3, amplitude=math.radians(0.5), band_hz=(0.3, 4.0))

    def poses(times_s: Array) -> Poses:
        place = np.zeros((len(times_s), 3))
        place[:, 0] = 250.0 * _to_and_fro(times_s)
        camera = np.tile([0.0, 0.0, -distance_mm], (len(times_s), 1))
        return _before_moving_board(Poses(camera, np.tile(np.eye(3), (len(camera), 1, 1))), place, tremor(times_s))

    return poses


def both(distance_mm: float, seed: int) -> Motion:
    """Camera and board move a quarter of a metre each, against each other; the camera looks at the middle between.

    Source: the third of the published ways to film (Qing et al. 2026); the tremor is ours.
    """
    tremor = _tremor(seed, count=6, amplitude=math.radians(0.5), band_hz=(0.3, 4.0))

    def poses(times_s: Array) -> Poses:
        shake, place = tremor(times_s), np.zeros((len(times_s), 3))
        place[:, 0] = 125.0 * _to_and_fro(times_s)
        return _before_moving_board(_aimed(-place - [0.0, 0.0, distance_mm], shake[:, :3]), place, shake[:, 3:])

    return poses


def alike(distance_mm: float, seed: int) -> Motion:
    """Camera and board move alike, so that there is no parallax, however far they go; the camera's hand trembles."""
    tremor = _tremor(seed, count=3, amplitude=math.radians(0.5), band_hz=(0.3, 4.0))
    return lambda times_s: _aimed(np.tile([0.0, 0.0, -distance_mm], (len(times_s), 1)), tremor(times_s))


def _to_and_fro(times_s: Array) -> Array:
    """From -1 to 1 in two seconds at constant speed, and back."""
    return 2 / math.pi * np.arcsin(np.sin(math.pi * (times_s - 1.0) / 2.0))


def _before_moving_board(camera: Poses, place_mm: Array, turn_rad: Array) -> Poses:
    """A camera in the room, before a board at places (T, 3) that is turned by (T, 3) about its own axes."""
    turn = from_vectors(turn_rad)
    return Poses(_turned_back(turn, camera.camera_mm - place_mm), camera.rotation @ turn)


def _turned_back(turns: Array, vectors: Array) -> Array:
    """Vectors (T, 3) turned by the inverse of each of the turns (T, 3, 3)."""
    return np.asarray(np.einsum("tji,tj->ti", turns, vectors))


def measured_run(distance_mm: float) -> Motion:
    """The measured hand-held run that is shipped; longer films run it forth and back.

    Source: TUM RGB-D benchmark, freiburg1_xyz, motion capture (Sturm et al., IROS 2012), CC BY 4.0.
    """
    return _spline(_read_shipped_run(MEASURED_RUN), "the measured run", distance_mm)


def walk(distance_mm: float, seed: int) -> Motion:
    """A phone carried about a room, scaled to a walk around the badge; the seed chooses where in the run it begins.

    The camera looks at the badge, but for half of the phone's own fast turns.  A film longer than the rest of the run
    goes to and fro.

    Convention: as in `phone_walk`.
    Source: ARKit-Data-Logger, ARKit_camera_pose.txt (Pyojin Kim, 2019), MIT licence; scale and aim are ours.
    """
    rows = _rows(csv.DictReader(_read_shipped_run(PHONE_WALK).splitlines()), "the measured walk")
    begin, length = rows[0, 0], rows[-1, 0] - rows[0, 0]
    place = spline(rows[:, 0], distance_mm * around_badge(rows[:, 1:4]))
    turn = spline(rows[:, 0], fast_turns_rad(rows[:, 0], rows[:, 4:]))
    start = np.random.default_rng(seed).uniform(0.0, length)

    def poses(times_s: Array) -> Poses:
        clock = begin + to_and_fro_s(start + times_s, length)
        return _aimed(place(clock), turn(clock))

    return poses


def _read_shipped_run(name: str) -> str:
    """The text of a motion file that is shipped."""
    return resources.files("moireid.simulate").joinpath(name).read_text(encoding="utf-8")


#: Motions by name, of distance in mm and seed.
NAMED: dict[str, Callable[[float, int], Motion]] = {
    "handheld": lambda distance_mm, seed: measured_run(distance_mm),
    "walk": walk,
    "linear": linear,
    "sway": sway,
    "static": static,
    "roll": roll,
    "oblique": oblique,
    "tumble": tumble,
    "circle": circle,
    "board": board,
    "both": both,
    "alike": alike,
}


def from_csv(path: AnyPath, distance_mm: float) -> Motion:
    """A motion file with columns t_s, x_mm, y_mm, z_mm, qx, qy, qz, qw: camera to world, z forward, y down.

    Convention: the world is turned so that the mean view looks straight at the badge from `distance_mm`.
    Raises: MediaError where the file cannot be read or lacks a column.
    """
    path = as_path(path)
    try:
        text = read_regular(path, MOST_TABLE_BYTES).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise MediaError(f"motion file {path} cannot be read; give a CSV with columns {', '.join(COLUMNS)}") from error
    return _spline(text, str(path), distance_mm)


def _spline(text: str, source: str, distance_mm: float) -> Motion:
    """Interpolate the rows of a motion file; beyond its end the motion runs backwards."""
    reader = csv.DictReader(text.splitlines())
    try:
        rows = _rows(reader, source)
    except csv.Error as error:
        raise MediaError(f"{source} is not readable as CSV ({error}); correct it") from error
    turn = continuous(rows[:, 4:] / np.linalg.norm(rows[:, 4:], axis=1, keepdims=True))
    # The mean turn has the least squared distance from all: the main axis of their quaternions.
    mean = from_quaternions(np.linalg.eigh(turn.T @ turn)[1][:, -1:].T)[0]
    way = (rows[:, 1:4] - rows[:, 1:4].mean(axis=0)) @ mean + np.array([0.0, 0.0, -distance_mm])
    place, facing = spline(rows[:, 0], way), spline(rows[:, 0], turn)
    begin, length = rows[0, 0], rows[-1, 0] - rows[0, 0]

    def poses(times_s: Array) -> Poses:
        phase = np.mod(times_s, 2 * length)
        clock = begin + np.where(phase <= length, phase, 2 * length - phase)
        return Poses(place(clock), from_quaternions(facing(clock)).transpose(0, 2, 1) @ mean)

    return poses


def _rows(reader: csv.DictReader[str], source: str) -> Array:
    """The figures of a motion file, (T, 8), checked.  Raises: MediaError."""
    if not reader.fieldnames or not set(COLUMNS) <= set(reader.fieldnames):
        raise MediaError(f"{source} lacks columns; a motion file has {', '.join(COLUMNS)}")
    try:
        rows = np.array([[float(row[name]) for name in COLUMNS] for row in reader])
    except (TypeError, ValueError) as error:
        raise MediaError(f"{source} holds a value that is no number; correct that row") from error
    if len(rows) < 4 or not np.all(np.isfinite(rows)) or not np.all(np.diff(rows[:, 0]) > 1e-6):
        raise MediaError(f"{source} has {len(rows)} rows; a motion needs 4 or more, finite, with rising times")
    # Motion capture may count times from 1970, so only their span is checked.
    if np.ptp(rows[:, 0]) > 1e6 or np.abs(rows[:, 1:4]).max() > 1e6:
        raise MediaError(f"{source} spans more than 1e6 s or holds a place beyond 1 km; correct its units")
    sizes = np.abs(rows[:, 4:]).max(axis=1)
    if sizes.min() < 0.4 or sizes.max() > 1.5:
        raise MediaError(f"{source} holds a quaternion that is far from length 1; correct that row")
    return rows


def _aimed(camera_mm: Array, error_rad: Array) -> Poses:
    """Upright cameras that look at the board's centre, then turned a little (T, 3) about their own axes."""
    forward = -camera_mm / np.linalg.norm(camera_mm, axis=1, keepdims=True)
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    upright = np.stack([right, np.cross(forward, right), forward], axis=1)
    return Poses(camera_mm, from_vectors(error_rad) @ upright)


def _tremor(seed: int, *, count: int, amplitude: float, band_hz: tuple[float, float]) -> Callable[[Array], Array]:
    """Smooth random motion (T, count) with this root mean square: sums of eight sines of random frequency and phase."""
    rng = np.random.default_rng(seed)
    frequency = rng.uniform(*band_hz, (8, count))
    phase = rng.uniform(0, 2 * math.pi, (8, count))

    def value(times_s: Array) -> Array:
        turns = 2 * math.pi * frequency * times_s[:, None, None] + phase
        return np.asarray(amplitude * np.sin(turns).sum(axis=1) / 2.0)

    return value
