"""Orders to read photographs and films of charts: `moireid.reading` has them carried out by a sealed process.

A sheet or a camera as that process answers it is checked for its types; what its figures are is on its word.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta

from moireid.badge import Badge
from moireid.calibration.camera_fit import CameraFound, camera_from_film
from moireid.calibration.sheet_reading import SheetReading, read_sheet
from moireid.reading.answers import FilmAnswer, checked
from moireid.reading.film_orders import Ask, Progress, Send
from moireid.reading.film_reader import Reader

Size = Annotated[int, Meta(ge=1, le=1 << 20)]
Share = Annotated[float, Meta(ge=0, le=1)]
Positive = Annotated[float, Meta(gt=0)]
Row = tuple[float, float, float]


@dataclass(frozen=True)
class SheetOrder:
    """A photograph or film of a pitch test, as `read_sheet` reads it."""

    film: Path
    chart: Badge
    distance_m: float | None = None
    focal_px: float | None = None
    measured_scale: float | None = None

    def read(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send what it shows."""
        found = read_sheet(self.film, self.chart, self.distance_m, self.focal_px, self.measured_scale, progress)
        # Figures may be numpy's.
        send({"result": msgspec.to_builtins(found, enc_hook=np.generic.item)})


@dataclass(frozen=True)
class CameraOrder:
    """A film of the camera chart, as `camera_from_film` reads it."""

    film: Path

    def read(self, send: Send, ask: Ask, progress: Progress) -> None:
        """Send the camera."""
        found = camera_from_film(self.film, progress=progress)
        send({"result": asdict(found) | {"matrix": found.matrix.tolist(), "distortion": found.distortion.tolist()}})


class CameraAnswer(msgspec.Struct, forbid_unknown_fields=True):
    """The fields of `CameraFound`."""

    size_px: tuple[Size, Size]
    matrix: tuple[Row, Row, Row]
    distortion: Annotated[list[float], Meta(min_length=5, max_length=5)]
    focal_sd_px: Positive
    error_px: Annotated[float, Meta(ge=0)]
    views: Size
    cover: tuple[Share, Share]


def sheet_read(order: SheetOrder, reader: Reader, progress: Callable[[int, int | None], None]) -> SheetReading:
    """What pictures of a pitch test show.  Raises: MoireIdError as `read_sheet`; MediaError where the reader fails."""
    return checked(_result(order, reader, progress), SheetReading, order.film)


def camera_read(order: CameraOrder, reader: Reader, progress: Callable[[int, int | None], None]) -> CameraFound:
    """The camera of a film.  Raises: MoireIdError as `camera_from_film`; MediaError where the reader fails."""
    found = checked(_result(order, reader, progress), CameraAnswer, order.film)
    arrays = {"matrix": np.array(found.matrix), "distortion": np.array(found.distortion)}
    return CameraFound(**msgspec.structs.asdict(found) | arrays)


def _result(
    order: SheetOrder | CameraOrder, reader: Reader, progress: Callable[[int, int | None], None]
) -> dict[str, Any]:
    return checked(reader.read(order, progress), FilmAnswer, order.film).result
