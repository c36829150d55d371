"""What the Issue pages say of the choices, and the link budget in words."""

from __future__ import annotations

from typing import Any

from moireid.designer.formats import FORMATS
from moireid.designer.reach import verdict_reach_m
from moireid_studio.jobs.orders import Checked

#: The formats: what they are called, and what they go into; sizes and ranges are said by `FORMATS`.
FORMAT_WORDS = {
    "board": ("Board", "in a mount of its own, for cameras farther away"),
    "cr80": ("Card", "in a card holder, as large as a credit card"),
    "a7": ("A7", "in an A7 pouch"),
    "4x3in": ("4 × 3 inches", "in a pouch of that size"),
    "a6": ("A6", "in an A6 pouch"),
    "a5": ("A5", "in an A5 pouch, or as a sign on a desk"),
    "webcam": ("Video call", "in the hand or on a stand, before a laptop's camera"),
}
#: What the templates are: value, name, words, and the picture that shows one; without a value the usual one is taken.
TEMPLATES = [
    ("", "As usual", "The name, and beside or above it lines and pictures. For video calls: large letters.", "plain"),
    ("conference", "Conference", "A large name on a band in your colour, the logo above it.", "conference"),
    ("newsroom", "Newsroom", "A press card: the portrait, name and lines, the logo.", "newsroom"),
    ("court", "Court", "Sober: name and office between two lines, the seal above.", "court"),
    ("webcam", "Video call", "Name and lines as large as there is room.", "webcam"),
]


def _formats() -> list[tuple[str, str, str]]:
    """Each format: its value, its name, and in words its size, what it goes into, and from where it is filmed."""
    told = []
    for value, (name, where) in FORMAT_WORDS.items():
        form = FORMATS[value]
        size = " × ".join(f"{side:g}" for side in form.size_mm)
        near, far = form.range_m
        told.append((value, name, f"{size}\u00a0mm, {where}; filmed from {near:g} to {far:g}\u00a0m"))
    return told


#: For the templates of the pages; in `styles` the plain one has the value that leaves the choice to the format.
CHOICES: dict[str, Any] = {"formats": _formats(), "styles": TEMPLATES}


def sentences(checked: Checked, format_name: str | None = None) -> list[str]:
    """What a person should know before a badge is made: from where it can be read, and how surely."""
    badge = checked.badge
    camera = "in a call, by a camera of 720p" if format_name == "webcam" else "with a phone at 1080p"
    assert badge.range_m is not None
    told = [
        f"Badge {badge.id} carries {badge.payload_bits} bits, and is made to be filmed from {badge.range_m[0]:g} to "
        f"{badge.range_m[1]:g} m {camera}."
    ]
    chances = {metres: _chance(link.decode_probability) for metres, link in checked.links}
    if len(set(chances.values())) == 1:
        told.append(f"Over all of that the identity is read {next(iter(chances.values()))}.")
    else:
        told += [f"From {metres:g} m the identity is read {chance}." for metres, chance in chances.items()]
    reach_m, far_m = verdict_reach_m(badge), badge.range_m[1]
    until = "" if reach_m >= far_m else f" up to {reach_m:.1f} m; from farther away, move it more"
    told.append(f"Whoever films it must move it. Eight seconds of swaying are enough for a verdict{until}.")
    return told


def _chance(probability: float) -> str:
    """A probability as a share of films."""
    if probability >= 0.9999:
        return "in practically every film of eight seconds"
    if probability >= 0.01:
        return f"in about {100 * probability:.{0 if probability < 0.99 else 1}f} of 100 films of eight seconds"
    return "in hardly any film"
