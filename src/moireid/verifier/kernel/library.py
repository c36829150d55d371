"""The kernel's library: where it is, which version, and how pictures and arrays are handed over to it."""

from __future__ import annotations

import ctypes
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.errors import MoireIdError

#: As `KERNEL_VERSION` of kernel.h.
VERSION = 5
#: `hatch_build.py` writes it next to this file.
NAME = {"win32": "_kernel.dll", "darwin": "_kernel.dylib"}.get(sys.platform, "_kernel.so")


class PictureStruct(ctypes.Structure):
    """`Picture` of kernel.h."""

    _fields_ = (
        ("rows", ctypes.c_void_p),
        ("levels", ctypes.c_void_p),
        ("stride", ctypes.c_int64),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
    )


class PlacesStruct(ctypes.Structure):
    """`Places` of kernel.h."""

    _fields_ = (
        ("across", ctypes.c_void_p),
        ("down", ctypes.c_void_p),
        ("middle", ctypes.c_double * 2),
        ("hull", ctypes.c_double * 8),
        ("count", ctypes.c_int32),
    )


@cache
def library() -> ctypes.CDLL:
    """The library, loaded once.

    Raises: MoireIdError where it is missing or of another version.
    """
    path = Path(__file__).with_name(NAME)
    advice = "build it by `make setup`, or install moireid anew"
    try:
        found = ctypes.CDLL(str(path))
    except OSError as error:
        raise MoireIdError(f"the library {path} cannot be loaded ({error}); {advice}") from error
    version = found.kernel_version()
    if version != VERSION:
        raise MoireIdError(f"the library {path} has version {version}, {VERSION} is needed; {advice}")
    return found


def address(array: NDArray[Any], kind: type[Any], count: int | None = None) -> int:
    """Where an array's numbers are, for C.  The caller keeps the array.

    Parameters: kind: of number; count: how many there must be.
    """
    flags, size = array.flags, array.size
    if array.dtype != kind or not flags.c_contiguous or (count is not None and size != count):
        raise ValueError(f"{array.dtype} {array.shape} is no row-by-row array of {count} {np.dtype(kind)}")
    # NumPy's own description of an array takes four times as long to make.
    if flags.writeable and size:
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    return int(array.__array_interface__["data"][0])


def picture_struct(coded: NDArray[np.uint8], levels: NDArray[np.float32]) -> PictureStruct:
    """A picture's bytes (height, width), whose rows may be padded, and the value of each byte (256,)."""
    height, width = coded.shape
    if coded.dtype != np.uint8 or not coded.size or coded.strides[1] != 1 or coded.strides[0] < width:
        raise ValueError(f"{coded.dtype} {coded.shape} with strides {coded.strides} is no picture of bytes")
    rows = address(coded[0], np.uint8)
    struct = PictureStruct(rows, address(levels, np.float32, 256), coded.strides[0], width, height)
    # An address keeps nothing alive.
    struct.arrays = coded, levels
    return struct
