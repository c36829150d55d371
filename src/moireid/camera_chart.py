"""The chart that a camera is calibrated with: a ChArUco board, squares with a small marker in every white one.

A picture of a part of it is enough, as each marker has a number.  Its size does not matter for the camera; that it is
flat does.
"""

from __future__ import annotations

import cv2

#: Squares along and down, their side, and that of a marker, mm: 184 x 253 mm, which A4 and letter paper hold.
COLUMNS, ROWS, SQUARE_MM, MARKER_MM = 8, 11, 23.0, 17.25


def chart_board() -> cv2.aruco.CharucoBoard:
    """The board, in OpenCV's convention: x right, y down, mm, origin at the upper left corner."""
    markers = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    return cv2.aruco.CharucoBoard((COLUMNS, ROWS), SQUARE_MM, MARKER_MM, markers)
