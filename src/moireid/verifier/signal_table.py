"""The signals of a film as named columns: arrays, CSV, or a data frame.

Convention: parallax u = Cx / |Cz| at the page's middle, positive where the camera is at +x; phases in rad, mean 0.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError

#: Columns of every film; those of grating G are measured_rad_G, predicted_rad_G and phase_sd_rad_G.
COLUMNS = ("frame", "time_s", "camera_x_mm", "camera_y_mm", "camera_z_mm", "parallax_x", "parallax_y")
PHASES = ("measured_rad", "predicted_rad", "phase_sd_rad")


class SignalTable(dict[str, NDArray[Any]]):
    """Columns (T,) by name, one entry for each frame that was judged: `COLUMNS`, and `PHASES` of each grating.

    "frame" holds whole numbers; an unreadable frame has an infinite phase_sd_rad.
    """

    @classmethod
    def of(cls, columns: Mapping[str, NDArray[Any]]) -> SignalTable:
        """The table of these columns, and empty ones where a column of every film is missing."""
        empty = {name: np.empty(0) for name in COLUMNS}
        return cls(empty | dict(columns))

    @classmethod
    def from_csv(cls, text: str) -> SignalTable:
        """The table that `to_csv` wrote, with the digits that are in the text."""
        head, *rows = csv.reader(io.StringIO(text))
        columns = np.array(rows, float).reshape(len(rows), len(head)).T
        table = cls(zip(head, columns, strict=True))
        return cls(table | {"frame": table["frame"].astype(np.int64)})

    def to_csv(self) -> str:
        """The columns as CSV text with six digits, one line for each frame."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(self)
        for row in zip(*self.values(), strict=True):
            writer.writerow([int(row[0]), *(f"{value:.6g}" for value in row[1:])])
        return out.getvalue()

    @property
    def gratings(self) -> int:
        """Number of gratings."""
        return sum(name.startswith("predicted_rad_") for name in self)

    def most_moved(self) -> int:
        """Number of the grating whose predicted phase moves most."""
        if not len(self["time_s"]):
            raise SpecError("nothing could be measured in this film, so it has no signals; the report says why")
        return int(np.argmax([np.std(self[f"predicted_rad_{number}"]) for number in range(self.gratings)]))
