"""Values of options of `simulate`: effects, flaws, and a camera's measured lens."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from moireid.errors import MediaError, SpecError
from moireid.simulate.flaw_table import read_flaw


class CheckedText(click.ParamType[str]):
    """A text that another function checks, by raising SpecError."""

    def __init__(self, name: str, check: Callable[[str], object]) -> None:
        self.name, self._check = name, check

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The text as it was given.  Raises: click.BadParameter."""
        try:
            self._check(str(value))
        except SpecError as error:
            self.fail(f"{error}.", param, ctx)
        return str(value)


def _check_effect(text: str) -> None:
    """Importing the effects takes a second, so that only a film that has one waits for it."""
    from moireid.simulate.effects.table import effect_named

    effect_named(text)


EFFECT, FLAW = CheckedText("effect", _check_effect), CheckedText("flaw", read_flaw)


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
