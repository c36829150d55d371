"""The pictures of a badge: logos and portraits from files, and the QR code of its id.

Files are PNG, JPEG or SVG, and are checked before they are loaded.  Pictures are printed as rasters, logos in SVG too:
with `MOST_SIDE_PX` pixels a side no printer shows the difference, and page and preview show the same.

The QR code says `moireid:` and the id.  The id is on the badge in letters too, so the code holds no secret and proves
nothing: it only shows which id to look up.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from moireid.artwork.svg import draw_svg
from moireid.errors import SpecError
from moireid.files import AnyPath, read_regular

if TYPE_CHECKING:
    from PIL import Image


#: A larger file or picture is no logo for a badge, and would fill the memory.
MOST_BYTES, MOST_PIXELS = 20_000_000, 50_000_000
#: Longer side of a picture as it is kept: 85 mm at 600 dpi.
MOST_SIDE_PX = 2000
FORMATS = ("PNG", "JPEG")
#: Width over height of a portrait, and the share of what is cut off that is cut above the face.
PORTRAIT_SHAPE, PORTRAIT_UP = 0.8, 0.3
ADVICE = "give a PNG, JPEG or SVG file"


def load_picture(path: AnyPath, what: str) -> Image.Image:
    """The picture of a file, RGBA, upright, its longer side at most `MOST_SIDE_PX`.

    Parameters: what: "logo" or "portrait", for messages.
    Raises: SpecError for a file that is absent, too large or no such picture, and for an SVG as `draw_svg`.
    """
    try:
        data = read_regular(path, MOST_BYTES)
    except OSError as error:
        raise SpecError(f"{what} {path} cannot be read ({error.strerror}); {ADVICE}") from error
    return picture_of(data, f"{what} {path}")


@lru_cache(maxsize=16)
def picture_of(data: bytes, whose: str, draw: Callable[[bytes, str, int], bytes] = draw_svg) -> Image.Image:
    """The picture of a file's bytes; `whose` names it in messages, `draw` draws an SVG.

    Raises: SpecError as `load_picture`.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    if _is_svg(data):
        data = draw(data, whose, MOST_SIDE_PX)
    too_large = f"at most {MOST_PIXELS / 1e6:.0f} million are read; {ADVICE} that is smaller"
    try:
        with warnings.catch_warnings(action="error", category=Image.DecompressionBombWarning):
            opening = Image.open(io.BytesIO(data), formats=FORMATS)
        with opening as opened:
            if opened.width * opened.height > MOST_PIXELS:
                raise SpecError(f"{whose} has {opened.width} x {opened.height} pixels, {too_large}")
            upright = ImageOps.exif_transpose(opened).convert("RGBA")
    except (Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        # Pillow refuses a header of very many pixels before it says how many.
        raise SpecError(f"{whose} has far too many pixels, {too_large}") from error
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise SpecError(f"{whose} is no picture that is read here; {ADVICE}") from error
    upright.thumbnail((MOST_SIDE_PX, MOST_SIDE_PX), Image.Resampling.LANCZOS)
    # White around a logo would make it small and push it off its place.
    box = upright.getchannel("A").getbbox()
    if box is None:
        raise SpecError(f"{whose} is wholly transparent; {ADVICE} that shows something")
    return upright.crop(box)


def as_portrait(picture: Image.Image) -> Image.Image:
    """The part of a picture that has the shape of a portrait, `PORTRAIT_SHAPE`: its middle, nearer to its top."""
    width, height = picture.size
    if width > PORTRAIT_SHAPE * height:
        wide = round(PORTRAIT_SHAPE * height)
        left = (width - wide) // 2
        return picture.crop((left, 0, left + wide, height))
    high = round(width / PORTRAIT_SHAPE)
    top = round(PORTRAIT_UP * (height - high))
    return picture.crop((0, top, width, top + high))


def _is_svg(data: bytes) -> bool:
    return b"<svg" in data[:4096] or data.lstrip()[:5] == b"<?xml"


#: White around the code, in modules (ISO/IEC 18004 asks for four).
QUIET_MODULES = 4


def words_of(badge_id: str) -> str:
    """The text of the QR code."""
    return f"moireid:{badge_id}"


@lru_cache(maxsize=256)
def modules_of(badge_id: str) -> Sequence[Sequence[bool]]:
    """The modules of the code without its white border, True where dark; square, row by row from the top.

    Source: ISO/IEC 18004 by segno, at level M, which corrects 15 %.
    """
    import segno

    code = segno.make_qr(words_of(badge_id), error="m", boost_error=False)
    return tuple(tuple(bool(module) for module in row) for row in code.matrix)
