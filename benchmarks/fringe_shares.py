"""How much of a badge its fringes take, with squares and with a frame, for each format: run
`.venv/bin/python benchmarks/fringe_shares.py`, which takes a second.
"""

from __future__ import annotations

from collections.abc import Iterator

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.frames import own_rect
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script


def fringe_share(badge: Badge) -> float:
    """Area of a badge's gratings over that of its board."""
    x0, y0, x1, y1 = badge.outline_mm
    rects = [own_rect(grating.axis, grating.rect_mm) for grating in badge.gratings]
    return sum((rect[2] - rect[0]) * (rect[3] - rect[1]) for rect in rects) / ((x1 - x0) * (y1 - y0))


def rows(wish: Wish) -> Iterator[Row]:
    """One row a format."""
    for name in FORMATS:
        yield {"format": name} | {
            markers: fringe_share(design_badge(in_format(Request("Ada", markers=markers), name), bytes(8)))
            for markers in ("squares", "frame")
        }


BENCH = Bench(rows, {"format": "<8", "squares": ">9.1%", "frame": ">9.1%"})

if __name__ == "__main__":
    run_script(__file__)
