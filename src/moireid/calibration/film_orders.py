"""Orders to read photographs and films of charts: `moireid.reading` has them carried out by a sealed process.

A sheet or a camera as that process answers it is checked for its types; what its figures are is on its word.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from moireid.badge import Badge
from moireid.calibration.camera_fit import camera_from_film
from moireid.calibration.sheet_reading import read_sheet
from moireid.reading.answers import FilmAnswer, checked
from moireid.reading.film_orders import Ask, Order, Progress, Send
from moireid.reading.film_reader import Reader

Found = TypeVar("Found")


def send_sheet(
    send: Send,
    ask: Ask,
    progress: Progress,
    *,
    film: Path,
    chart: Badge,
    distance_m: float | None = None,
    focal_px: float | None = None,
    measured_scale: float | None = None,
) -> None:
    """Send what a photograph or film of a pitch test shows, as `read_sheet` reads it."""
    found = read_sheet(film, chart, distance_m, focal_px, measured_scale)
    # Figures may be numpy's.
    send({"result": msgspec.to_builtins(found, enc_hook=np.generic.item)})


def send_camera(send: Send, ask: Ask, progress: Progress, *, film: Path) -> None:
    """Send the camera that filmed its chart, as `camera_from_film` reads it."""
    send({"result": msgspec.to_builtins(camera_from_film(film, progress=progress))})


def film_read(
    order: Order,
    model: type[Found],
    film: Path,
    reader: Reader,
    progress: Callable[[int, int | None], None],
) -> Found:
    """What a film of a chart shows: a `SheetReading` or a `CameraFound`, as the order asks.

    Raises: MoireIdError as `read_sheet` or `camera_from_film`; MediaError where the reader fails.
    """
    return checked(checked(reader.read(order, progress), FilmAnswer, film).result, model, film)
