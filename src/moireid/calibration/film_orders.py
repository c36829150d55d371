"""Photographs and films of charts, read by a sealed process.

A sheet or a camera as that process answers it is checked for its types; what its figures are is on its word.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np

from moireid.reading.answers import FilmAnswer, checked
from moireid.reading.film_orders import Ask, Progress, Send
from moireid.reading.film_reader import Reader

Found = TypeVar("Found")


def read_chart(send: Send, ask: Ask, progress: Progress, *, film: Path, read: Callable[..., Any]) -> None:
    """Send what a photograph or film shows to `read`."""
    # Figures may be numpy's.
    send({"result": msgspec.to_builtins(read(film, progress=progress), enc_hook=np.generic.item)})


def film_read(
    film: Path,
    read: Callable[..., Found],
    model: type[Found],
    reader: Reader,
    progress: Callable[[int, int | None], None],
) -> Found:
    """What a film of a chart shows: a `SheetReading` or a `CameraFound`.

    Parameters: read: `read_sheet` with its arguments, or `camera_from_film`; model: what it returns.
    Raises: MoireIdError as `read`; MediaError where the reader fails.
    """
    said = reader.read(partial(read_chart, film=film, read=read), progress)
    return checked(checked(said, FilmAnswer, film).result, model, film)
