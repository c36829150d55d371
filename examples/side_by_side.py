"""Show two verified films side by side, each above the course of its fringes: a film (.mp4) and a still (.png).

Arguments: OUT.mp4, then a title, a film and its report's folder for the left side, and the same for the right side.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import av
import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

#: Pixels: the whole picture, and the middle of a film in it, which is so much of the film's height.
WIDTH, HEIGHT, SHOWN, SHARE = 1280, 720, (628, 464), 0.68
#: Pixels from the top to the films.
TOP = 62
#: Seconds between the moments that the still shows.
MOMENTS_S = (0.0, 0.7, 1.5)
COLOURS = {"accept": "#1c7c4a", "reject": "#b3261e", "inconclusive": "#8a6100"}
VERDICTS = {"accept": "✓ accepted", "reject": "✗ rejected", "inconclusive": "? inconclusive"}
PREDICTED, MEASURED = "#e3a27f", "#1f5fa8"


@dataclass(frozen=True)
class Side:
    """One film and what its report says: times (T,) s, and fringe phases, measured and predicted, (T,) rad."""

    title: str
    film: Path
    verdict: str
    times_s: NDArray[np.float64]
    measured_rad: NDArray[np.float64]
    predicted_rad: NDArray[np.float64]

    @classmethod
    def read(cls, title: str, film: str, report: str) -> Side:
        """The film, and the figures in its report's folder."""
        verdict = json.loads((Path(report) / "report.json").read_text(encoding="utf-8"))["verdict"]
        with (Path(report) / "signals.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        times, measured, predicted = (
            np.array([float(row[name]) for row in rows]) for name in ("time_s", "measured_rad_0", "predicted_rad_0")
        )
        return cls(title, Path(film), verdict, times, measured, predicted)

    def pictures(self) -> Iterator[tuple[float, NDArray[np.uint8]]]:
        """Time of every frame, and its middle, (height, width, 3), red, green, blue."""
        with av.open(str(self.film)) as container:
            for frame in container.decode(video=0):
                picture = frame.to_ndarray(format="rgb24")
                high = round(SHARE * picture.shape[0])
                wide = high * SHOWN[0] // SHOWN[1]
                x, y = (picture.shape[1] - wide) // 2, (picture.shape[0] - high) // 2
                middle = picture[y : y + high, x : x + wide]
                yield float(frame.time), np.asarray(cv2.resize(middle, SHOWN, interpolation=cv2.INTER_AREA), np.uint8)


def plotted(figure: Figure, side: Side, place: tuple[float, float, float, float]) -> Axes:
    """The side's title and verdict over empty axes with the predicted course of the fringes."""
    axes = figure.add_axes(place)
    axes.plot(side.times_s, side.predicted_rad, color=PREDICTED, lw=5, label="where optics puts the fringes")
    axes.plot([], [], color=MEASURED, lw=2, label="where the film shows them")
    axes.set_ylim(np.min(side.predicted_rad) - 0.6, np.max(side.predicted_rad) + 1.8)
    axes.set(xticks=[], yticks=[])
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel("time", fontsize=10)
    axes.legend(loc="upper center", ncols=2, frameon=False, fontsize=11)
    return axes


def titled(figure: Figure, side: Side, x: float, y: float, right: float) -> None:
    """The side's title, and the verdict in its colour."""
    figure.text(x, y, side.title, fontsize=15, va="center")
    figure.text(right, y, VERDICTS[side.verdict], color=COLOURS[side.verdict], fontsize=16, va="center", ha="right")


def drawn(figure: Figure) -> NDArray[np.uint8]:
    """The figure's pixels, (height, width, 3), red, green, blue."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def write_film(path: Path, sides: list[Side]) -> None:
    """Both films, with the measured course growing below each as the film goes on."""
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100)
    axes = [plotted(figure, side, (0.006 + 0.5 * k, 0.045, 0.488, 0.21)) for k, side in enumerate(sides)]
    for k, side in enumerate(sides):
        titled(figure, side, 0.006 + 0.5 * k, 0.957, 0.494 + 0.5 * k)
    ground = drawn(figure)
    courses = []
    for one, side in zip(axes, sides, strict=True):
        course = one.transData.transform(np.column_stack([side.times_s, side.measured_rad]))
        courses.append(np.round(np.column_stack([course[:, 0], HEIGHT - course[:, 1]]) * 16).astype(np.int32))
    ink = tuple(int(MEASURED[k : k + 2], 16) for k in (1, 3, 5))
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "20", "preset": "veryfast"})
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for pair in zip(*(side.pictures() for side in sides), strict=False):
            picture = ground.copy()
            for k, (time_s, shown) in enumerate(pair):
                left = 8 + k * WIDTH // 2
                picture[TOP : TOP + SHOWN[1], left : left + SHOWN[0]] = shown
                past = courses[k][sides[k].times_s <= time_s + 1e-6]
                cv2.polylines(picture, [past], False, ink, 2, cv2.LINE_AA, shift=4)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())


def write_still(path: Path, sides: list[Side]) -> None:
    """Three moments of each film in a row, and the whole course of its fringes at the end of the row."""
    figure = Figure(figsize=(16, 8.4), dpi=100)
    for k, side in enumerate(sides):
        low = 0.02 + 0.5 * (1 - k)
        frames = list(takewhile(lambda frame: frame[0] <= MOMENTS_S[-1], side.pictures()))
        for n, moment_s in enumerate(MOMENTS_S):
            time_s, shown = min(frames, key=lambda frame: abs(frame[0] - moment_s))
            cell = figure.add_axes((0.01 + 0.185 * n, low, 0.179, 0.37))
            cell.imshow(shown[:, 104:-104])
            cell.set_title(f"after {time_s:.1f} s", fontsize=10)
            cell.axis("off")
        axes = plotted(figure, side, (0.585, low + 0.04, 0.4, 0.33))
        axes.plot(side.times_s, side.measured_rad, color=MEASURED, lw=2)
        titled(figure, side, 0.01, low + 0.435, 0.559)
    cv2.imwrite(str(path), drawn(figure)[..., ::-1])


def main(out: Path, words: list[str]) -> None:
    """Write the film and, next to it, the still."""
    sides = [Side.read(*words[:3]), Side.read(*words[3:])]
    write_film(out, sides)
    write_still(out.with_suffix(".png"), sides)
    print(f"{out} and {out.with_suffix('.png').name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
