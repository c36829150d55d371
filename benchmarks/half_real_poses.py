"""What one view of a held board errs by: the parallax coordinate by one webcam against that by all of them together.

All cameras film one board at once, and their places are known (`rotation`, `translation` in `camera_array.toml`), so
that the board's pose by all corners in all pictures is far better than that by one picture.  The same figures are given
of the verifier's poses on a half-real film, whose true poses are those that the badge was drawn at.

Convention: errors of Cx/|Cz| in the badge's frame, less their mean; what they leave of the law is that times the law's
slope, 2 pi g_eff / p_r, less what another gain explains.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from moireid.badge import Badge
from moireid_lab.bench.bench_frame import Row

Array = NDArray[np.float64]
#: Borders of the bands in which an error's power is given, Hz; residuals beyond this weigh less, px.
BANDS_HZ, ROBUST_PX = (0.2, 1.0), 1.0
MM_PER_M = 1000.0


def joint_pose(seen: list[tuple[Array, Array, Array, Array, Array]], start: tuple[Array, Array]) -> tuple[Array, Array]:
    """The board's pose in the world: turn (3, 3) and place (3,), mm.

    Parameters: seen: of each camera its corners on the board (N, 3) and in the picture (N, 2), its matrix, distortion,
        and pose of the world (3, 4), mm; start: as the result.
    """

    def left(pose: Array) -> Array:
        turn, errors = cv2.Rodrigues(pose[:3])[0], []
        for solid, corners, matrix, distortion, world in seen:
            local = (solid @ turn.T + 100.0 * pose[3:]) @ world[:, :3].T + world[:, 3]
            found, _ = cv2.projectPoints(local.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, distortion)
            errors.append((found[:, 0] - corners).ravel())
        return np.concatenate(errors) / ROBUST_PX

    first = np.concatenate([cv2.Rodrigues(start[0])[0][:, 0], start[1] / 100.0])
    found = least_squares(left, first, loss="soft_l1").x
    return cv2.Rodrigues(found[:3])[0], 100.0 * found[3:]


def error_row(estimated: Array, true: Array, badge: Badge, fps: float) -> Row:
    """Figures of a series of parallax coordinates (T,) against the true ones."""
    error = estimated - true - np.mean(estimated - true)
    grating, away = badge.gratings[0], true - true.mean()
    slope = 2 * np.pi * badge.lens.thickness_mm / badge.lens.refractive_index / grating.pitch_mm
    left = error - away * float(error @ away) / float(away @ away)
    hz, power = np.fft.rfftfreq(len(error), 1 / fps), np.abs(np.fft.rfft(error)) ** 2
    shares = [float(power[band].sum() / power.sum()) for band in _bands(hz)]
    return {
        "poses": len(error),
        "rms": float(error.std()),
        "median": float(np.median(np.abs(error))),
        **dict(zip(("< 0.2 Hz", "to 1 Hz", "faster"), shares, strict=True)),
        "of the law, rad": slope * float(left.std()),
        "its median": slope * float(np.median(np.abs(left))),
    }


def _bands(hz: Array) -> list[NDArray[np.bool_]]:
    slow, fast = BANDS_HZ
    return [hz < slow, (slow <= hz) & (hz < fast), hz >= fast]
