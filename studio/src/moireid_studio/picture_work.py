"""What the process does that reads visitors' logos and portraits: sealed, within limits, and made for that alone.

It reads them as the command does, and hands back pictures of its own making: no byte of a visitor's file gets further.
"""

from __future__ import annotations

import base64
import io

from PIL import Image, JpegImagePlugin, PngImagePlugin  # noqa: F401 - the formats are loaded ahead

from moireid.artwork.pictures import picture_of
from moireid.artwork.svg import draw_svg_here
from moireid.errors import SpecError
from moireid.sandbox.child import Talk

#: Longer side of a picture as it is handed back, px: 51 mm at 600 dpi, as wide as any on a card.
MOST_SIDE_PX = 1200
#: A picture of more colours is a photograph, which is handed back as JPEG where nothing of it is transparent.
DRAWN_COLOURS, QUALITY = 4096, 92
#: What takes more is handed back smaller.
MOST_BYTES = 4_000_000


def read_pictures(talk: Talk) -> None:
    """Read pictures, each sent as its bytes and how messages name it, until None or no more comes."""
    # Loaded before anything of a visitor's is read.
    import resvg_py  # noqa: F401

    talk.send({"ready": True})
    while (sent := talk.next()) is not None:
        data, whose = sent
        try:
            picture = picture_of(data, whose, draw_svg_here)
        except SpecError as error:
            talk.send({"fault": str(error)})
            continue
        talk.send({"picture": base64.b64encode(encoded(picture)).decode()})


def encoded(picture: Image.Image) -> bytes:
    """A drawing as PNG, a photograph as JPEG, its longer side at most `MOST_SIDE_PX`."""
    side = MOST_SIDE_PX
    opaque = picture.getchannel("A").getextrema()[0] == 255
    while True:
        small = picture.convert("RGB") if opaque else picture.copy()
        small.thumbnail((side, side), Image.Resampling.LANCZOS)
        made = io.BytesIO()
        if opaque and small.getcolors(DRAWN_COLOURS) is None:
            small.save(made, format="JPEG", quality=QUALITY, subsampling=0)
        else:
            small.save(made, format="PNG")
        if made.tell() <= MOST_BYTES:
            return made.getvalue()
        side //= 2
