"""Colours by hex digits or CSS name, and what can be read on them.

Convention: red, green, blue from 0 to 1 (sRGB).
"""

from __future__ import annotations

from moireid.errors import SpecError

Colour = tuple[float, float, float]
INK: Colour = (0.0, 0.0, 0.0)
PAPER: Colour = (1.0, 1.0, 1.0)
#: Share of a colour in its tint, the rest is white.
TINT_SHARE = 0.14
#: Least contrast of large letters on their ground (WCAG 2.2, 1.4.3).
LEAST_CONTRAST = 3.0


def colour_named(text: str) -> Colour:
    """The colour of '#0a7d6e' or 'teal'.  Raises: SpecError where it is none."""
    from PIL import ImageColor

    try:
        red, green, blue, *clear = ImageColor.getrgb(text.strip())
        if not all(0 <= part <= 255 for part in (red, green, blue)) or any(part < 255 for part in clear):
            raise ValueError("beyond a colour's range, or seen through")
    except ValueError as error:
        raise SpecError(
            f"colour {text[:40]!r} is not known; give six hex digits such as #0a7d6e, or a CSS name such as teal"
        ) from error
    return red / 255, green / 255, blue / 255


def tint(colour: Colour) -> Colour:
    """A light shade of the colour, as a ground for dark letters."""
    red, green, blue = (1 - TINT_SHARE * (1 - part) for part in colour)
    return red, green, blue


def contrast(one: Colour, other: Colour) -> float:
    """Contrast of two colours, 1 to 21.  Source: WCAG 2.2, relative luminance."""
    light, dark = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def letters_on(ground: Colour) -> Colour:
    """White or black, whichever is read better on a ground; white where it is read well enough."""
    return PAPER if contrast(PAPER, ground) >= LEAST_CONTRAST else INK


def readable(colour: Colour, ground: Colour) -> Colour:
    """The colour where letters in it are read on the ground, else black or white."""
    return colour if contrast(colour, ground) >= LEAST_CONTRAST else letters_on(ground)


def _luminance(colour: Colour) -> float:
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
