"""Which of the markers in a frame belong together: pages of four, each with its own homography.

Several badges of one layout bear the same four numbers, so a number does not tell which badge a marker is of; only
geometry does.  Two markers of one page are squares whose distance fits their sizes, which markers of two pages are by
rare chance alone, and a third or fourth that fits settles it.

Source: greedy search: pairs that a homography maps within its tolerance, each grown by what fits best; the page with
most markers is taken first, its markers are set aside, and so on.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: A corner may lie so far from its place, in sides of its marker and in px: what blur and coding do to small markers.
TOLERANCE_SIDES, TOLERANCE_PX = 0.15, 2.0
#: Of one number the largest so many are looked at, so that a wall of markers cannot hold a verifier up.
MOST_OF_ONE = 6
#: Pages of one frame that are told, largest first.
MOST_PAGES = 4
#: Two markers smaller than this tell the perspective so poorly that the page is also placed without it.
PLAIN_BELOW_PX = 16.0


def pages_of(quads_px: Array, index: Sequence[int], corners_mm: Array) -> list[Array]:
    """Homographies page mm -> image px of the pages that markers make up, the largest in the picture first.

    Parameters: quads_px (M, 4, 2): corners of the markers found; index (M,): which of the page's four each is;
        corners_mm (4, 4, 2): of the page, as `marker_corners_mm` has them.
    Returns: homographies (3, 3) with h33 = 1; each of two markers at least, no two of which have the same number.
        After them, for each of two markers under `PLAIN_BELOW_PX`, another place of its page, without perspective.
    Source: module docstring; where no number is seen twice, all markers are fitted at once, with outliers left out.
    """
    order = sorted(range(len(index)), key=lambda k: -cv2.contourArea(quads_px[k].astype(np.float32)))
    left = [k for place, k in enumerate(order) if [index[j] for j in order[:place]].count(index[k]) < MOST_OF_ONE]
    found: list[Array] = []
    plain: list[Array] = []
    while len({index[k] for k in left}) >= 2 and len(found) < MOST_PAGES:
        alone = len({index[k] for k in left}) == len(left)
        # In the order in which they were found, as which corners RANSAC draws depends on it.
        group = sorted(left) if alone else _largest_group(quads_px, index, corners_mm, left)
        if len(group) < 2:
            break
        page = fit_homography(corners_mm[[index[k] for k in group]].reshape(-1, 2), quads_px[group].reshape(-1, 2))
        if page is not None:
            found.append(page)
            plain += _plain(quads_px[group], corners_mm[[index[k] for k in group]])
        if alone:
            break
        left = [k for k in left if k not in group]
    return [page for pages in (found, plain) for page in sorted(pages, key=lambda page: -_area_px2(page, corners_mm))]


def _plain(quads_px: Array, squares_mm: Array) -> list[Array]:
    """The page by turn, scale and shift alone, through two small markers (2, 4, 2); [] for others.

    From near straight ahead that places the other two within registration's reach; from 30 degrees aside and more the
    page looks too narrow for it, and the homography is the better guess.
    """
    side = float(np.linalg.norm(quads_px - np.roll(quads_px, 1, axis=1), axis=2).mean())
    if len(quads_px) != 2 or side >= PLAIN_BELOW_PX:
        return []
    similar, _ = cv2.estimateAffinePartial2D(squares_mm.reshape(-1, 2), quads_px.reshape(-1, 2), method=cv2.LMEDS)
    if similar is None or not np.all(np.isfinite(similar)):
        return []
    return [np.vstack([similar, [0.0, 0.0, 1.0]])]


def _largest_group(quads_px: Array, index: Sequence[int], corners_mm: Array, left: list[int]) -> list[int]:
    """Markers of the page that most of them make up, of equals the one that fits best; [] where no two fit."""
    best: tuple[int, float, list[int]] = (0, 0.0, [])
    for one in left:
        for other in left:
            if index[one] >= index[other]:
                continue
            group, misfit = [one, other], _misfit(quads_px, index, corners_mm, [one, other])
            while misfit <= 1.0 and len(group) < 4:
                more = [[*group, k] for k in left if index[k] not in {index[j] for j in group}]
                tried = [(_misfit(quads_px, index, corners_mm, grown), grown) for grown in more]
                least = min(tried, default=(np.inf, group))
                if least[0] > 1.0:
                    break
                misfit, group = least
            if misfit <= 1.0 and (len(group), -misfit) > best[:2]:
                best = (len(group), -misfit, group)
    return best[2]


def _misfit(quads_px: Array, index: Sequence[int], corners_mm: Array, group: list[int]) -> float:
    """The worst corner of a group under the homography that fits all of them, in units of the tolerance."""
    page, image = corners_mm[[index[k] for k in group]].reshape(-1, 2), quads_px[group].reshape(-1, 2)
    homography, _ = cv2.findHomography(page, image, 0)
    if homography is None or not np.all(np.isfinite(homography)):
        return float("inf")
    # All of the page must lie before the camera and show its face, or the fit is none of a picture.
    depth = np.column_stack([corners_mm.reshape(-1, 2), np.ones(16)]) @ homography[2]
    if not (np.all(depth > 0) or np.all(depth < 0)) or np.linalg.det(homography) * np.sign(depth[0]) <= 0:
        return float("inf")
    mapped = cv2.perspectiveTransform(page.reshape(-1, 1, 2), homography).reshape(-1, 4, 2)
    quads = quads_px[group]
    side = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=2).mean(axis=1)
    apart = np.linalg.norm(mapped - quads, axis=2).max(axis=1)
    return float((apart / np.maximum(TOLERANCE_SIDES * side, TOLERANCE_PX)).max())


def fit_homography(page_mm: Array, image_px: Array) -> Array | None:
    """Homography page -> image through at least four pairs (N, 2), None where they do not agree.

    A marker that was found where the others do not expect it (another badge, a misread bit) is left out by RANSAC.
    """
    side_px = float(np.linalg.norm(image_px[1] - image_px[0]))
    homography, used = cv2.findHomography(page_mm, image_px, cv2.RANSAC, max(TOLERANCE_PX, TOLERANCE_SIDES * side_px))
    if homography is None or used.sum() < 8 or not np.all(np.isfinite(homography)):
        return None
    return np.asarray(homography / homography[2, 2])


def same_page(one: Array, other: Array, corners_mm: Array) -> bool:
    """Whether two homographies put the page at one place: apart by less than a quarter of the smaller one."""
    first, second = (_outline(homography, corners_mm) for homography in (one, other))
    size = min(float(np.ptp(points, axis=0).max()) for points in (first, second))
    return float(np.linalg.norm(first - second, axis=1).mean()) < size / 4


def _outline(homography: Array, corners_mm: Array) -> Array:
    """Middles of the four markers in the picture, (4, 2)."""
    middles = corners_mm.mean(axis=1).reshape(-1, 1, 2)
    return np.asarray(cv2.perspectiveTransform(middles, homography).reshape(-1, 2), float)


def _area_px2(homography: Array, corners_mm: Array) -> float:
    return float(cv2.contourArea(_outline(homography, corners_mm).astype(np.float32)))
