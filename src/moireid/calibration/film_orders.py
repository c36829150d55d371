"""Orders to read photographs and films of charts: `moireid.reading` has them carried out by a sealed process.

A sheet or a camera as that process answers it is checked for its types; what its figures are is on its word.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from moireid.badge import Badge
from moireid.calibration.camera_fit import camera_from_film
from moireid.calibration.sheet_reading import read_sheet
from moireid.reading.answers import FilmAnswer, checked
from moireid.reading.film_orders import Ask, Progress, Send
from moireid.reading.film_reader import Reader

Found = TypeVar("Found")


@dataclass(frozen=True)
class SheetOrder:
    """A photograph or film of a pitch test, as `read_sheet` reads it."""

    film: Path
    chart: Badge
    distance_m: float | None = None
    focal_px: float | None = None
    measured_scale: float | None = None

    def __call__(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send what it shows."""
        found = read_sheet(self.film, self.chart, self.distance_m, self.focal_px, self.measured_scale)
        # Figures may be numpy's.
        send({"result": msgspec.to_builtins(found, enc_hook=np.generic.item)})


@dataclass(frozen=True)
class CameraOrder:
    """A film of the camera chart, as `camera_from_film` reads it."""

    film: Path

    def __call__(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send the camera."""
        send({"result": msgspec.to_builtins(camera_from_film(self.film, progress=progress))})


def film_read(
    order: SheetOrder | CameraOrder,
    model: type[Found],
    reader: Reader,
    progress: Callable[[int, int | None], None],
) -> Found:
    """What a film of a chart shows: a `SheetReading` or a `CameraFound`, as the order asks.

    Raises: MoireIdError as `read_sheet` or `camera_from_film`; MediaError where the reader fails.
    """
    return checked(checked(reader.read(order, progress), FilmAnswer, order.film).result, model, order.film)
