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

from moireid.reading.answers import checked
from moireid.reading.film_orders import Parts, Progress
from moireid.reading.film_reader import Reader

Found = TypeVar("Found")


def read_chart(progress: Progress, *, film: Path, read: Callable[..., Any]) -> Parts:
    """What a photograph or film shows to `read`."""
    # Figures may be numpy's.
    yield {"result": msgspec.to_builtins(read(film, progress=progress), enc_hook=np.generic.item)}


def film_read(film: Path, read: Callable[..., Found], model: type[Found], reader: Reader, progress: Progress) -> Found:
    """What a film of a chart shows: a `SheetReading` or a `CameraFound`.

    Parameters: read: `read_sheet` with its arguments, or `camera_from_film`; model: what it returns.
    Raises: MoireIdError as `read`; MediaError where the reader fails.
    """
    found = reader.read(partial(read_chart, film=film, read=read), progress)
    return checked(found.result, model, film)
