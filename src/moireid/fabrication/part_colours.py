"""Colours of the parts of a mount, in all files that show them."""

from __future__ import annotations

#: Red, green and blue (sRGB) and opacity, 0 to 255.
Rgba = tuple[int, int, int, int]
#: By kind of part.
COLOURS: dict[str, Rgba] = {
    "base": (70, 80, 95, 255),
    "pad": (225, 220, 205, 255),
    "page": (245, 245, 240, 255),
    "sheet": (150, 200, 235, 90),
    "frame": (40, 90, 160, 255),
    "lips": (235, 240, 245, 110),
    "cover": (205, 225, 240, 130),
    "screw": (150, 150, 155, 255),
    "tray": (60, 65, 75, 255),
    "clip": (200, 90, 50, 255),
    "stand": (200, 90, 50, 255),
}


def kind_of(name: str) -> str:
    """The kind of a part, a key of `COLOURS`."""
    return name.split("-", maxsplit=1)[0]


def linear_colour(kind: str) -> tuple[float, float, float, float]:
    """Red, green and blue of a kind of part, linear, which CAD kernel and glTF count in, and its opacity, 0 to 1.

    Source: IEC 61966-2-1 (sRGB).
    """
    *light, opacity = (value / 255 for value in COLOURS[kind])
    red, green, blue = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in light)
    return red, green, blue, opacity
