"""Values of options of `simulate`: effects, flaws, and a camera's measured lens."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.errors import MediaError, SpecError
from moireid.simulate.flaw_table import read_flaw

if TYPE_CHECKING:
    pass

EFFECTS = (
    "zoom",
    "zoom-step",
    "autoframe",
    "autoframe-zoom",
    "breathing",
    "crop",
    "tile",
    "stretch",
    "anamorphic",
    "eis",
    "jello",
    "shutter",
    "shutter-up",
    "tnr",
    "tnr-mc",
    "blend",
    "mix",
    "repeat",
    "freeze",
    "skip",
    "jitter",
    "slow-motion",
    "clahe",
    "tone-map",
    "halos",
    "exposure",
    "glare",
    "backdrop",
    "hlg",
    "pq",
    "call",
    "crf",
)
STRENGTHS = ("light", "ordinary", "strong")


class EffectName(click.ParamType[str]):
    """NAME or NAME:STRENGTH."""

    name = "effect"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name as it was given.  Raises: click.BadParameter."""
        kind, colon, strength = str(value).partition(":")
        if kind not in EFFECTS:
            self.fail(f"{kind!r} is not one of {', '.join(EFFECTS)}.", param, ctx)
        if colon and strength not in STRENGTHS:
            self.fail(f"{strength!r} is no strength; choose {', '.join(STRENGTHS)}.", param, ctx)
        return str(value)


class FlawValue(click.ParamType[str]):
    """NAME=VALUE."""

    name = "flaw"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The text as it was given.  Raises: click.BadParameter."""
        try:
            read_flaw(str(value))
        except SpecError as error:
            self.fail(f"{error}.", param, ctx)
        return str(value)


class LensFile(click.ParamType[tuple[float, ...]]):
    """A calibration, as `FilmOptions.lens`."""

    name = "file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        """Focal length, axis x and y, k1 and k2.  Raises: click.BadParameter."""
        from moireid.verifier.camera.known_camera import load_camera

        try:
            lens = load_camera(Path(value))
        except (SpecError, MediaError) as error:
            self.fail(f"{error}.", param, ctx)
        return lens.focal, *lens.axis, lens.k1, lens.k2
