"""Somebody before a camera: a photograph of a face that is free of rights (it comes with scikit-image), and a badge."""

from __future__ import annotations

import functools

import cv2
import numpy as np
from numpy.typing import NDArray

#: The face in the photograph, as dlib finds it, and where it is put in a picture of 1280 x 720: centre and size, px.
IN_PHOTOGRAPH = (222.5, 126.5, 87.0)
AT_PX, SIZE_PX = (640.0, 165.0), 190.0
#: That place in the plane of a badge at rest, mm (`bench.live_film`): 640 mm away, 900 px.
FACE_MM = (np.array(AT_PX) - (639.5, 359.5)) / 900.0 * 640.0


@functools.cache
def portrait() -> NDArray[np.uint8]:
    """The photograph as a webcam frames a person, (720, 1280) grey."""
    from skimage import data

    grey = cv2.cvtColor(data.astronaut(), cv2.COLOR_RGB2GRAY)
    x, y, size = IN_PHOTOGRAPH
    scale = SIZE_PX / size
    warp = np.array([[scale, 0, AT_PX[0] - scale * x], [0, scale, AT_PX[1] - scale * y]])
    picture = cv2.warpAffine(grey, warp, (1280, 720), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picture, np.uint8)
