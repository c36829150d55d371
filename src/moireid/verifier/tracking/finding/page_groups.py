"""Which of the markers in a frame belong together: pages of four, each with its own homography.

Badges of one layout carry the same four numbers, so a number does not identify the badge; only geometry does.  The
distance of two markers of one page fits their sizes.  For markers of two pages that is rare, and a third or fourth
fitting marker excludes it.

Source: greedy search: start from pairs that a homography maps within the tolerance, and add the markers that fit best.
    Take the page with most markers, set its markers aside, and repeat.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: A corner may be off by this much, in sides of its marker and in px, because of blur and coding of small markers.
TOLERANCE_SIDES, TOLERANCE_PX = 0.15, 2.0
#: At most this many markers of one number are used, the largest, so that a wall of markers cannot stall a verifier.
MOST_OF_ONE = 6
#: A marker is near where its page had it within this share of the page's size.
MOVED_SHARE = 0.5
#: Most pages returned from one frame, largest first.
MOST_PAGES = 4


#: A page of four markers that fit this well, in units of the tolerance, is taken without a look at all others.
WELL = 0.3


#: At most this many groups are fitted.  Two whole pages take 7 and four 30; three pages that each show another three of
#: their markers 78 to 122.  A wall of markers would take 800; a group takes 0.24 ms.
MOST_TRIALS = 130


@dataclass
class Trials:
    """How many groups of markers were fitted, which takes most of the time where many markers are found."""

    number: int = 0


def pages_of(quads_px: Array, index: Sequence[int], corners_mm: Array, trials: Trials | None = None) -> list[Array]:
    """Homographies page mm -> image px of the pages formed by markers, the largest in the picture first.

    Parameters: quads_px (M, 4, 2): corners of the markers found; index (M,): number of each on the page, 0 to 3;
        corners_mm (4, 4, 2): as `marker_corners_mm`; trials: counts the groups that are fitted.
    Returns: homographies (3, 3) with h33 = 1; each has at least two markers, all of different numbers.
    Source: module docstring; if no number is seen twice, all markers are fitted at once, without outliers.
    """
    order = sorted(range(len(index)), key=lambda k: -cv2.contourArea(quads_px[k].astype(np.float32)))
    trials = Trials() if trials is None else trials
    left = [k for place, k in enumerate(order) if [index[j] for j in order[:place]].count(index[k]) < MOST_OF_ONE]
    found: list[Array] = []
    while len({index[k] for k in left}) >= 2 and len(found) < MOST_PAGES and trials.number < MOST_TRIALS:
        alone = len({index[k] for k in left}) == len(left)
        # Keep the order in which they were found: the corners that RANSAC draws depend on it.
        group = sorted(left) if alone else _largest_group(quads_px, index, corners_mm, left, trials)
        if len(group) < 2:
            break
        page = fit_homography(corners_mm[[index[k] for k in group]].reshape(-1, 2), quads_px[group].reshape(-1, 2))
        if page is not None:
            found.append(page)
        if alone:
            break
        left = [k for k in left if k not in group]
    return sorted(found, key=lambda page: -_area_px2(page, corners_mm))


def where_it_was(quads_px: Array, index: Sequence[int], corners_mm: Array, before: Array) -> list[int]:
    """Which markers to take for a page that was there a moment ago: all that were found, if one page fits them; else
    those near where it had them, if they are two at least.

    Where some markers are in false places, RANSAC finds a page too, but takes ten times as long.  Where a number is
    seen twice there are several pages, and no marker is left out.
    Parameters: as `moved_page`.
    """
    every = list(range(len(index)))
    if not 2 < len(index) == len(set(index)) or _misfit(quads_px, index, corners_mm, every) <= 1.0:
        return every
    then = _outline(before, corners_mm)
    apart = np.linalg.norm(quads_px.mean(axis=1) - then[list(index)], axis=1)
    near = [k for k in every if apart[k] < MOVED_SHARE * float(np.ptp(then, axis=0).max())]
    return near if len(near) >= 2 else every


def moved_page(quads_px: Array, index: Sequence[int], corners_mm: Array, before: Array) -> Array | None:
    """The page as it was a moment ago, turned, scaled and shifted in the picture onto two markers, or shifted onto one;
    None for others.

    Two markers show a page's tilt poorly, and registration by the gratings' borders begins only from within a pixel.
    Parameters: as `pages_of`, and before: homography page mm -> px of a recent frame.
    Source: least squares over the eight corners; tilt and perspective stay those of the recent frame.
    """
    if len(quads_px) == 1:
        x, y = quads_px[0].mean(axis=0) - _outline(before, corners_mm)[index[0]]
        shifted = np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]]) @ before
        return np.asarray(shifted / shifted[2, 2])
    if len(quads_px) != 2 or index[0] == index[1]:
        return None
    then = cv2.perspectiveTransform(corners_mm[list(index)].reshape(-1, 1, 2), before)
    similar, _ = cv2.estimateAffinePartial2D(then, quads_px.reshape(-1, 1, 2), method=cv2.LMEDS)
    if similar is None or not np.all(np.isfinite(similar)):
        return None
    moved = np.vstack([similar, [0.0, 0.0, 1.0]]) @ before
    return np.asarray(moved / moved[2, 2])


def pages_of_one(quad_px: Array, square_mm: Array, focal_px: float) -> list[Array]:
    """The two pages that one marker (4, 2) may be of, by a camera of about that focal length that looks at it.

    Source: a small square is seen alike from two sides (Collins and Bartoli, Infinitesimal Plane-Based Pose Estimation,
    2014), as OpenCV solves it.
    """
    middle_mm, middle_px = square_mm.mean(axis=0), quad_px.mean(axis=0)
    solid = np.column_stack([square_mm - middle_mm, np.zeros(4)])
    lens = np.array([[focal_px, 0.0, middle_px[0]], [0.0, focal_px, middle_px[1]], [0.0, 0.0, 1.0]])
    _, turns, places, _ = cv2.solvePnPGeneric(solid, quad_px.reshape(-1, 1, 2), lens, None, flags=cv2.SOLVEPNP_IPPE)
    from_page = np.array([[1.0, 0.0, -middle_mm[0]], [0.0, 1.0, -middle_mm[1]], [0.0, 0.0, 1.0]])
    found = []
    for turn, place in zip(turns, places, strict=True):
        page = lens @ np.column_stack([cv2.Rodrigues(turn)[0][:, :2], place]) @ from_page
        if np.all(np.isfinite(page)) and page[2, 2] != 0:
            found.append(np.asarray(page / page[2, 2]))
    return found


def _largest_group(
    quads_px: Array, index: Sequence[int], corners_mm: Array, left: list[int], trials: Trials
) -> list[int]:
    """The group that most markers fit, and of equal groups the one that fits best; [] if no two markers fit."""
    best: tuple[int, float, list[int]] = (0, 0.0, [])
    for one in left:
        for other in left:
            if index[one] >= index[other]:
                continue
            if trials.number >= MOST_TRIALS:
                return best[2]
            group, misfit = [one, other], _misfit(quads_px, index, corners_mm, [one, other])
            trials.number += 1
            while misfit <= 1.0 and len(group) < 4:
                more = [[*group, k] for k in left if index[k] not in {index[j] for j in group}]
                tried = [(_misfit(quads_px, index, corners_mm, grown), grown) for grown in more]
                trials.number += len(tried)
                least = min(tried, default=(np.inf, group))
                if least[0] > 1.0:
                    break
                misfit, group = least
            if misfit <= 1.0 and (len(group), -misfit) > best[:2]:
                best = (len(group), -misfit, group)
            if len(group) == 4 and misfit <= WELL:
                return group
    return best[2]


def _misfit(quads_px: Array, index: Sequence[int], corners_mm: Array, group: list[int]) -> float:
    """Error of a group's worst corner under its best homography, in units of the tolerance."""
    page, image = corners_mm[[index[k] for k in group]].reshape(-1, 2), quads_px[group].reshape(-1, 2)
    homography, _ = cv2.findHomography(page, image, 0)
    if homography is None or not np.all(np.isfinite(homography)):
        return float("inf")
    # The page must lie before the camera and face it; otherwise no picture could show it so.
    depth = np.column_stack([corners_mm.reshape(-1, 2), np.ones(16)]) @ homography[2]
    if not (np.all(depth > 0) or np.all(depth < 0)) or np.linalg.det(homography) * np.sign(depth[0]) <= 0:
        return float("inf")
    mapped = cv2.perspectiveTransform(page.reshape(-1, 1, 2), homography).reshape(-1, 4, 2)
    quads = quads_px[group]
    side = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=2).mean(axis=1)
    apart = np.linalg.norm(mapped - quads, axis=2).max(axis=1)
    return float((apart / np.maximum(TOLERANCE_SIDES * side, TOLERANCE_PX)).max())


def fit_homography(page_mm: Array, image_px: Array) -> Array | None:
    """Homography page -> image from at least four pairs (N, 2); None if they do not agree.

    RANSAC leaves out a marker that does not fit the others (another badge, a misread bit).
    """
    side_px = float(np.linalg.norm(image_px[1] - image_px[0]))
    homography, used = cv2.findHomography(page_mm, image_px, cv2.RANSAC, max(TOLERANCE_PX, TOLERANCE_SIDES * side_px))
    if homography is None or used.sum() < 8 or not np.all(np.isfinite(homography)):
        return None
    return np.asarray(homography / homography[2, 2])


def same_page(one: Array, other: Array, corners_mm: Array) -> bool:
    """Whether two homographies put the page at the same place: apart by less than a quarter of the smaller one."""
    first, second = (_outline(homography, corners_mm) for homography in (one, other))
    size = min(float(np.ptp(points, axis=0).max()) for points in (first, second))
    return float(np.linalg.norm(first - second, axis=1).mean()) < size / 4


def _outline(homography: Array, corners_mm: Array) -> Array:
    """Middles of the four markers in the picture, (4, 2)."""
    middles = corners_mm.mean(axis=1).reshape(-1, 1, 2)
    return np.asarray(cv2.perspectiveTransform(middles, homography).reshape(-1, 2), float)


def _area_px2(homography: Array, corners_mm: Array) -> float:
    return float(cv2.contourArea(_outline(homography, corners_mm).astype(np.float32)))
