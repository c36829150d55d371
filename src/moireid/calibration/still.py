"""Pictures in: a photograph, or the first frames of a film, as grey pictures.

A photograph is turned upright, and its focal length is read, by the camera's metadata (EXIF), if there are any.
"""

from __future__ import annotations

import math
import warnings
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError
from moireid.files import AnyPath, as_path, open_regular
from moireid.verifier.video import Film

#: Frames used of a film, and the step between them: after a quarter of a second the view has changed.
FILM_FRAMES, FILM_STRIDE = 6, 8
#: A larger picture shows no more of a chart, and could fill the memory.  Below 179 million, where Pillow opens none.
MAX_PIXELS = 150_000_000
#: Diagonal of 35 mm film, the reference of a camera's equivalent focal length; its directory and tag in EXIF.
FILM_DIAGONAL_MM = 43.2666
EXIF_FOLDER, EXIF_FOCAL_35MM = 0x8769, 0xA405


def load_pictures(path: AnyPath) -> tuple[list[NDArray[np.uint8]], float | None]:
    """Read a photograph or some frames of a film as grey pictures.

    Parameters
    ----------
    path : str or Path
        A photograph or a film of the chart.

    Returns
    -------
    list of array (height, width) of uint8
        One picture of a photograph, up to `FILM_FRAMES` of a film.
    float or None
        The focal length in px that the camera noted; None where it noted none, and for a film.

    Raises
    ------
    MediaError
        Where the file is neither, or too large.
    """
    path = as_path(path)
    if not path.is_file():
        raise MediaError(f"picture {path} does not exist or is no file; give a photograph or a film of the chart")
    still = _photograph(path)
    if still is not None:
        return [still[0]], still[1]
    frames = Film(path).frames()
    return [frame.luma for frame in islice(frames, 0, FILM_FRAMES * FILM_STRIDE, FILM_STRIDE)], None


def _photograph(path: Path) -> tuple[NDArray[np.uint8], float | None] | None:
    """A photograph and its focal length in pixels; None if the file is not a photograph."""
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        # Pillow only warns of huge pictures; the check here has its own limit and message.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with open_regular(path) as file, Image.open(file) as picture:
                if picture.width * picture.height > MAX_PIXELS:
                    raise Image.DecompressionBombError
                noted = picture.getexif().get_ifd(EXIF_FOLDER).get(EXIF_FOCAL_35MM)
                grey = np.asarray(ImageOps.exif_transpose(picture).convert("L"))
    except UnidentifiedImageError as error:
        if path.suffix.lower() in Image.registered_extensions():
            raise MediaError(f"picture {path} is damaged or no picture; export it anew, as JPEG or PNG") from error
        return None
    except Image.DecompressionBombError as error:
        most = f"{MAX_PIXELS // 1_000_000} million pixels"
        raise MediaError(f"picture {path} has more than the {most} that are read; give a smaller one") from error
    except (OSError, ValueError, SyntaxError) as error:
        raise MediaError(f"picture {path} breaks off or is damaged ({error}); take or export it anew") from error
    focal_px = None
    if isinstance(noted, (int, float)) and 5 <= noted <= 1000:
        focal_px = float(noted) / FILM_DIAGONAL_MM * math.hypot(*grey.shape)
    return grey, focal_px
