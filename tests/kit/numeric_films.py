"""Tracks of a badge made of numbers alone.

A homography a frame from a known camera, and the brightness that the optics' own formula gives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from moireid.badge import Badge, Cell
from moireid.frames import own_rect
from moireid.layers import is_smooth
from moireid.lenticule import view_law
from moireid.smooth_lines import LineField
from moireid.verifier.tracking.brightness_profiles import ProfileReader, Strip, read_across_mm
from moireid.verifier.tracking.track import Track

FRAMES, FPS, FOCAL = 90, 30.0, 1450.0


CENTRE = (959.5, 539.5)


@dataclass(frozen=True)
class Building:
    """How a badge was built: page over lens scale, where the sheet lies (rad), its twist (rad/mm), and the light."""

    scale: float = 1.0
    offset_rad: float = 0.0
    twist_rad_per_mm: float = 0.0
    noise: float = 2.0
    gain: float = 1.0


def course(badge: Badge) -> np.ndarray:
    """Camera centres (T, 3) in page mm: a hand's motion before the board's middle, 1.2 m away."""
    t = np.arange(FRAMES) / FPS
    x0, y0, x1, y1 = badge.outline_mm
    x = (x0 + x1) / 2 + 230.0 * np.sin(2.3 * t) + 40.0 * np.sin(5.1 * t + 1.0)
    y = (y0 + y1) / 2 + 60.0 * np.sin(1.7 * t + 0.5)
    return np.column_stack([x, y, -1200.0 + 30.0 * np.sin(1.1 * t)])


def homographies(camera: np.ndarray) -> np.ndarray:
    """Page mm -> px of a camera that turns a little about all its axes as it moves."""
    t = np.arange(FRAMES) / FPS
    found = []
    for k, place in enumerate(camera):
        a, b, c = 0.12 * math.sin(2.0 * t[k]), 0.10 * math.sin(1.5 * t[k] + 1), 0.05 * math.sin(1.2 * t[k])
        rx = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
        ry = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
        rz = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
        turn = rz @ ry @ rx
        matrix = np.array([[FOCAL, 0, CENTRE[0]], [0, FOCAL, CENTRE[1]], [0, 0, 1]])
        whole = matrix @ np.column_stack([turn[:, 0], turn[:, 1], -turn @ place])
        found.append(whole / whole[2, 2])
    return np.array(found)


def lines_seen(
    badge: Badge, strip: Strip, camera: np.ndarray, built: Building, across_mm: float | None = None
) -> np.ndarray:
    """Fringe phase at a strip's samples (T, N), or so far across; a dark line is shown where it is a whole turn."""
    across_mm = strip.across_mm if across_mm is None else across_mm
    grating = badge.gratings[strip.grating]
    away = np.abs(camera[:, 2:])
    own = strip.frame.places(camera[:, :2])
    mean = own[:, 0].mean()
    shown = mean + built.gain * (own[:, :1] - mean)
    tangent = (strip.along_mm[None, :] - shown) / away
    across = (across_mm - own[:, 1:]) / away
    place = strip.along_mm[None, :] - badge.lens.thickness_mm * tangent
    shift = view_law(badge.lens, grating.pitch_mm).phase_rad(tangent, across) * grating.pitch_mm / (2 * math.pi)
    if is_smooth(grating):
        page = LineField(grating).sampled(place + shift, np.full_like(shift, across_mm)) - 0.25
    else:
        pitch = np.array([cell_at(badge, strip, x).pitch_mm for x in strip.along_mm])
        edge = np.array([cell_at(badge, strip, x).edge_mm for x in strip.along_mm])
        page = (place + shift - edge - pitch / 4) / pitch
    lenses = place * built.scale / badge.lens.pitch_mm
    return 2 * math.pi * (page - lenses) + built.offset_rad + built.twist_rad_per_mm * across_mm


def cell_at(badge: Badge, strip: Strip, along_mm: float) -> Cell:
    grating = badge.gratings[strip.grating]
    for cell in (grating.cells[k] for k in strip.cells):
        low, _, high, _ = own_rect(grating.axis, cell.rect_mm)
        if low <= along_mm < high:
            return cell
    return grating.cells[strip.cells[-1]]


def rows_seen(badge: Badge, strip: Strip) -> list[float | None]:
    """Places across of which a strip shows the mean: some where lines bend, else its middle."""
    grating = badge.gratings[strip.grating]
    if not is_smooth(grating) or strip.uniform:
        return [None]
    return list(np.linspace(*read_across_mm(grating, strip.cells[0]), 5))


def brightness(turn: np.ndarray) -> np.ndarray:
    """Of fringes at a phase, counts."""
    return 130.0 - 40.0 * (np.cos(turn) + 0.25 * np.cos(2 * turn) - 0.15 * np.cos(3 * turn))


def filmed(badge: Badge, built: Building | None = None) -> Track:
    """The track of a film of `badge`."""
    built = built or Building()
    rng = np.random.default_rng(11)
    camera, strips = course(badge), tuple(ProfileReader(badge).strips)
    profiles = np.empty((FRAMES, len(strips), len(strips[0].along_mm)), np.float32)
    for index, strip in enumerate(strips):
        light = [brightness(lines_seen(badge, strip, camera, built, place)) for place in rows_seen(badge, strip)]
        profiles[:, index] = np.mean(light, axis=0) + 0.1 * (strip.along_mm - 100.0)
    profiles += built.noise * rng.standard_normal(profiles.shape).astype(np.float32)
    times = np.arange(FRAMES) / FPS
    return Track(
        badge,
        FRAMES,
        np.arange(FRAMES),
        times,
        homographies(camera),
        np.ones(FRAMES),
        tuple(profiles.transpose(1, 0, 2)),
        np.arange(FRAMES),
        strips,
        (1920, 1080),
    )


TYPICAL = Building(scale=1.003, offset_rad=2.1, twist_rad_per_mm=0.025)
