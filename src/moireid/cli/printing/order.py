"""What is to be printed, once the options have been read: the same for one person and for a list."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.cli.printing.wear import Wear

if TYPE_CHECKING:
    from moireid.designer import Request
    from moireid.fabrication.process import MountFigures


@dataclass(frozen=True)
class Order:
    """What the badge is to be, where its files go, and how to tell of it.

    request: without a person's name where there are many; mount: None where nothing was asked for; measured_scale: x
    and y; kept: files that were read, which nothing may replace; registry_url, actor, expires: of who enters the badge,
    None for nobody.
    """

    request: Request
    wear: Wear
    mount: str | None
    figures: MountFigures
    measured_scale: tuple[float, float]
    folder: Path
    kept: tuple[Path, ...]
    registry_url: str | None
    actor: str | None
    expires: str | None
    overwrite: bool
    as_json: bool
    explain: bool
