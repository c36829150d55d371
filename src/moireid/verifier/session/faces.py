"""Where the face is: searched a few times a second; between searches, and for a while when hidden, its place is kept.

The detector is dlib's frontal HOG detector, a maintained library whose weights are part of its package.  It finds faces
of 80 pixels and more, and its cost grows with the picture's area.  So the whole frame is shrunk, and a known face is
searched only around its place, at the size that suits the detector best.

Convention: boxes are x0, y0, x1, y1 in px of the film's own picture, centre of the top left pixel at (0, 0).
"""

from __future__ import annotations

import importlib

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.extras import missing_extra
from moireid.verifier.measuring import MIN_FACE_SCORE

Box = tuple[float, float, float, float]
#: Time between two searches: around a known face, and in the whole frame.
LOOK_S, SEARCH_S = 0.3, 0.5
#: The whole frame is shrunk to at most this width.  A face of an eighth of it is still found, as on a video call.
SEARCH_PX = 720
#: A known face is searched in a square of this many times its size, scaled so that the face has this many pixels.
AROUND_SIZES, FACE_PX = 2.5, 110
#: A box stays valid for this long after the face was last seen: without the badge in front of it, and behind the badge.
#: A talking person's head moves by less than half a face in that time.
CARRY_S, HIDDEN_S = 1.0, 4.0


class FaceFinder:
    """Finds the faces of a picture.

    Raises: MissingExtraError if dlib is not installed.
    Source: dlib's `get_frontal_face_detector` (histograms of oriented gradients, a linear classifier).
    """

    def __init__(self) -> None:
        try:
            dlib = importlib.import_module("dlib")
        except ImportError as missing:
            raise missing_extra("finding faces", "dlib", "face") from missing
        self._detector = dlib.get_frontal_face_detector()

    def all(self, luma: NDArray[np.uint8]) -> list[Box]:
        """The faces of a whole picture, the largest first."""
        return self.within(luma, (0, 0), min(1.0, SEARCH_PX / luma.shape[1]))

    def within(self, luma: NDArray[np.uint8], corner: tuple[int, int], scale: float) -> list[Box]:
        """The faces in a part of the picture, searched at another scale, the largest first."""
        if min(luma.shape) * scale < 1:
            return []
        way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        small = np.asarray(cv2.resize(luma, None, fx=scale, fy=scale, interpolation=way), np.uint8)
        # 0: the detector does not enlarge the picture once more.
        boxes, _, _ = self._detector.run(np.ascontiguousarray(small), 0, MIN_FACE_SCORE)
        found = []
        for one in sorted(boxes, key=lambda box: -box.area()):
            sides = (one.left(), one.top(), one.right() + 1, one.bottom() + 1)
            x0, y0, x1, y1 = (float(side / scale + corner[k % 2]) for k, side in enumerate(sides))
            found.append((x0, y0, x1, y1))
        return found


class FaceFollower:
    """Follows one face over a film: the known one while it is seen, otherwise the largest.

    Raises: MissingExtraError if dlib is not installed.
    """

    def __init__(self) -> None:
        self._finder = FaceFinder()
        self._face: Box | None = None
        self._seen_s, self._due_s = -np.inf, -np.inf
        #: How often the face was searched, and how often it was found.
        self.looks, self.seen = 0, 0

    def follow(self, luma: NDArray[np.uint8], time_s: float, *, hidden: bool = False) -> Box | None:
        """The face in this frame; None if its place is not known.

        Parameters: luma: the film's own picture; hidden: whether the badge covered it in the frame before.
        Convention: frames in order; a hidden face keeps its last place, and is searched only there.
        """
        if time_s >= self._due_s:
            self._look(luma, time_s, hidden)
        if time_s - self._seen_s > (HIDDEN_S if hidden else CARRY_S):
            self._face = None
        return self._face

    def _look(self, luma: NDArray[np.uint8], time_s: float, hidden: bool) -> None:
        self.looks += 1
        known = self._face
        found = self._near(luma, known) if known else self._anywhere(luma)
        self._due_s = time_s + (LOOK_S if known or found else SEARCH_S)
        if found is None and known and not hidden:
            # It may have moved away: search the whole frame, but keep its last place while that is still valid.
            found = self._anywhere(luma)
        if found is not None:
            self.seen += 1
            self._face, self._seen_s = found, time_s

    def _anywhere(self, luma: NDArray[np.uint8]) -> Box | None:
        return next(iter(self._finder.all(luma)), None)

    def _near(self, luma: NDArray[np.uint8], box: Box) -> Box | None:
        x0, y0, x1, y1 = box
        size = max(x1 - x0, y1 - y0)
        half = AROUND_SIZES * size / 2
        left, top = max(int((x0 + x1) / 2 - half), 0), max(int((y0 + y1) / 2 - half), 0)
        part = luma[top : int((y0 + y1) / 2 + half), left : int((x0 + x1) / 2 + half)]
        return next(iter(self._finder.within(part, (left, top), FACE_PX / size)), None)
