"""A forger with N photographs who re-poses them onto a trajectory that he could not choose.

He puts the nearest of his photographs over each frame, or cross-fades those around it; with a badge of several fields
he may do so field by field.  He is a good one: he knows from where each picture was taken and where each frame's camera
is, squares the pictures up without error, and reads them without noise.  He knows how far the trajectory goes to each
side, so he photographs from all over that box of views; he does not know which way it will take through the box.

Where the whole picture is taken, a badge of one axis needs pictures along one parallax, and one of more axes needs them
over a plane; where the distance changes too, it is one more coordinate, as the fringes' spacing goes with it.  Field by
field, every field is a badge of one axis, and the same pictures serve all of them (`for_all_fields`).  A lens array has
one field with two parallaxes, so it is always taken whole.

Convention: a view is (u, v, w): the parallax coordinates Cx/|Cz| and Cy/|Cz| of the board's centre, and `REACH_MM` over
the distance, by which fringes at that distance from the board's middle move as by a parallax.  Pictures are radiance
(rows, columns) over the whole board, as `scene.Instant.picture`; angles in radians, from x towards y.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.simulate.forgeries.rear_layer import ShownViews, SquaredUp
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
Picture = NDArray[np.float32]
Weights = list[tuple[int, float]]
#: Fineness of the photographs; a camera of 1150 px focal length sees 1.2 px to the mm at 1 m.
PX_PER_MM = 3.0
#: From the middle of a board to where half of its fringes lie nearer, mm.
REACH_MM = 35.0
#: A coordinate that changes by less over a course shows in no picture: 0.015 rad of phase.
STILL = 0.002
#: Views that represent the box of a trajectory.
BOX = 3000
#: Rounds in which the places of photographs move to the middle of the views that they represent.
ROUNDS = 20


@dataclass(frozen=True)
class Reposer:
    """What the forger has and does.

    count: photographs; blend: cross-fade those around in coded brightness, as editing programs do, else show the
    nearest; by_field: each field's region is taken from the photographs that suit its own axis.
    """

    count: int
    blend: bool = False
    by_field: bool = False

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """The film that these photographs make of a course."""
        del motion, fps
        away = np.abs(camera_mm[:, 2:])
        views = np.column_stack([camera_mm[:, :2] / away, REACH_MM / away])
        fields = fields_of(scene.badge) if self.by_field else [whole_of(scene.badge)]
        box = box_of(views)
        places = for_all_fields(box, fields, self.count) if self.by_field else over(box, fields[0], self.count)
        squared = SquaredUp(scene, PX_PER_MM)
        # Coded as a camera codes them, since they are cross-faded so.
        coded = [np.sqrt(squared.picture(REACH_MM / w * np.array([u, v, -1.0]))) for u, v, w in places.tolist()]
        regions = [_region(scene.badge, field, coded[0].shape) for field in fields]
        tables = [_table(*field.seen(views, places), blend=self.blend) for field in fields]

        def show(frame: int) -> Picture:
            picture = np.empty_like(coded[0])
            for region, table in zip(regions, tables, strict=True):
                parts = [np.float32(weight) * coded[k][region] for k, weight in table(frame)]
                picture[region] = np.sum(parts, axis=0)
            return np.asarray(picture**2, np.float32)

        return ShownViews(camera_mm, camera_mm, picture=show)


@dataclass(frozen=True)
class Field:
    """A part of the picture, and what of (u, v) it depends on, (2, 1) or (2, 2); grating: None for all of it."""

    senses: Array
    grating: Grating | None = None

    def seen(self, views: Array, *others: Array) -> list[Array]:
        """The coordinates on which the field depends, of views (T, 3) and others; those that stay still left out."""
        every = [np.column_stack([some[:, :2] @ self.senses, some[:, 2]]) for some in (views, *others)]
        moves = np.ptp(every[0], axis=0) > STILL
        return [some[:, moves] for some in every] if moves.any() else [some[:, :1] for some in every]


def angle_rad(grating: Grating) -> float:
    """The direction that a grating's fringes sense."""
    axis = grating.axis
    return {"x": 0.0, "y": math.pi / 2}[axis] if isinstance(axis, str) else math.radians(axis)


def _sense(angle: float) -> Array:
    return np.array([[math.cos(angle)], [math.sin(angle)]])


def fields_of(badge: Badge) -> list[Field]:
    """Each grating by itself; what lies between comes with the first."""
    every = [Field(_sense(angle_rad(grating)), grating) for grating in badge.gratings]
    return [Field(every[0].senses), *every[1:]]


def whole_of(badge: Badge) -> Field:
    """The whole picture: of one parallax where all gratings sense the same, else of both."""
    angles = {angle_rad(grating) for grating in badge.gratings}
    return Field(_sense(min(angles)) if len(angles) == 1 else np.eye(2))


def box_of(views: Array) -> Array:
    """Views all over the box of a course (T, 3), (BOX, 3), evenly.  Source: the sequence of Halton (1960)."""
    number = range(1, BOX + 1)
    shares = np.array([[_radical_inverse(k, base) for base in (2, 3, 5)] for k in number])
    return np.asarray(views.min(axis=0) + shares * np.ptp(views, axis=0))


def over(views: Array, field: Field, count: int) -> Array:
    """Views (N, 3) from which to photograph, so that each of some views (T, 3) has one near.

    Source: the mean of the views that are nearest to it (Lloyd 1982), begun by farthest points.
    """
    (seen,) = field.seen(views)
    chosen = [int(np.argmin(np.linalg.norm(seen - seen.mean(axis=0), axis=1)))]
    apart = np.full(len(seen), np.inf)
    while len(chosen) < count:
        apart = np.minimum(apart, np.linalg.norm(seen - seen[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(apart)))
    places = views[chosen]
    for _ in range(ROUNDS):
        here, there = field.seen(views, places)
        nearest = _nearest(there, here)
        places = np.array(
            [views[nearest == k].mean(axis=0) if np.any(nearest == k) else places[k] for k in range(count)]
        )
    return places


def for_all_fields(views: Array, fields: list[Field], count: int) -> Array:
    """Views (N, 3) that are evenly spread as every field sees them, over at least what it sees of some (T, 3).

    Source: along the first two directions the views count i and m i modulo N.  A third direction that is their
        difference, as at 0, 60 and 120 degrees, then counts (m - 1) i, which is even as well where N and m - 1 have no
        common part; so m is 1 for one and two axes and 2 for three.  Distances follow the radical inverse of i
        (Hammersley 1960).
    """
    first, last = fields[0].senses, fields[min(1, len(fields) - 1)].senses
    number, most = np.arange(count), max(count - 1, 1)
    shares = number / most, (number if len(fields) < 3 else 2 * number % count) / most
    goals = []
    for senses, share in zip((first, last), shares, strict=True):
        seen = views[:, :2] @ senses
        goals.append(seen.min() + share * np.ptp(seen))
    near = views[:, 2].min() + np.ptp(views[:, 2]) * np.array([_radical_inverse(int(k), 2) for k in number])
    if np.array_equal(first, last):
        return np.column_stack([np.outer(goals[0], first[:, 0]), near])
    return np.column_stack([np.linalg.solve(np.hstack([first, last]).T, np.array(goals)).T, near])


def _radical_inverse(number: int, base: int) -> float:
    """The digits of a number mirrored at the point: in base 2, the numbers 1, 2, 3 give 0.5, 0.25, 0.75."""
    found, share = 0.0, 1.0
    while number:
        number, digit = divmod(number, base)
        share /= base
        found += digit * share
    return found


def _table(views: Array, places: Array, *, blend: bool) -> Callable[[int], Weights]:
    """Which photographs make a frame, and with which weights; views (T, K), places (N, K)."""
    nearest = _nearest(places, views)
    if not blend or len(places) < places.shape[1] + 2:
        return lambda frame: [(int(nearest[frame]), 1.0)]
    if places.shape[1] == 1:
        order = np.argsort(places[:, 0])
        rank = np.interp(views[:, 0], places[order, 0], np.arange(len(places)))
        before = np.minimum(rank.astype(int), len(places) - 2)
        share = rank - before
        return lambda frame: [
            (int(order[before[frame]]), float(1 - share[frame])),
            (int(order[before[frame] + 1]), float(share[frame])),
        ]
    return _simplices(places, views, nearest)


def _simplices(places: Array, views: Array, nearest: NDArray[np.int64]) -> Callable[[int], Weights]:
    """Weights by the triangle or tetrahedron of photographs around a view; outside of all, by the nearest.

    Source: Delaunay 1934; "QJ" lets places lie in one plane.
    """
    from scipy.spatial import Delaunay

    net = Delaunay(places, qhull_options="QJ")
    around, most = net.find_simplex(views), places.shape[1]

    def weights(frame: int) -> Weights:
        if around[frame] < 0:
            return [(int(nearest[frame]), 1.0)]
        turn = net.transform[around[frame]]
        shares = turn[:most] @ (views[frame] - turn[most])
        return list(
            zip(map(int, net.simplices[around[frame]]), [*shares.tolist(), 1 - float(shares.sum())], strict=True)
        )

    return weights


def _nearest(places: Array, views: Array) -> NDArray[np.int64]:
    return np.asarray(np.argmin(np.linalg.norm(views[:, None] - places[None], axis=2), axis=1))


def _region(badge: Badge, field: Field, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Which pixels belong to a field, (rows, columns); all of them where it has no grating of its own."""
    if field.grating is None:
        return np.ones(shape, bool)
    x0, y0, x1, _ = badge.outline_mm
    inside = np.zeros(shape, np.uint8)
    places = (badge.corners_of(field.grating) - (x0, y0)) * shape[1] / (x1 - x0)
    cv2.fillPoly(inside, [np.rint(places).astype(np.int32)], 1)
    return inside > 0
