"""What each row of the paper's tables films, and which of the paper's own figures this project has on record.

The published renderings (Qing et al. 2026) move a camera half a metre along a straight line in two seconds, before two
line layers 1 mm apart in air, at seven distances, on ten courses that differ in small random turns: each is a single
sweep, one way, at constant speed, without noise.  A drift of the fringes, or a delay, is a mere constant on such a
course, so these films tell correlation and little more.

What is not on record here, and our reading: rendering 2 films the lens sheet of the prototype where rendering 1 films
the two layers; A to D film the prototype on a measured hand-held run, turned in the picture, from 45 degrees aside and
turning about all axes at once, each for 6 s from 1.2 m.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from moireid.badge import Badge, Cell, Grating, Lens, Markers
from moireid.simulate.wish import Wish

DISTANCES_M = (1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
COURSES = 10
#: One way along the path; `motion.linear` turns back then.
SWEEP = Wish(motion="linear", frames=120, fps=60.0, camera="ideal")
#: The prototype: sheet of 50 lines an inch over lines 0.52 mm apart, and a field of 80 mm.
LENS_PITCH_MM, LINE_PITCH_MM, GAP_MM, FIELD_MM = 0.508, 0.52, 1.0, 80.0


@dataclass(frozen=True)
class Condition:
    """A row of a table: courses before one board from one distance; paper: |rho| as published
    of a condition of that description, where it is on record.

    The film of a course is `wish` with the course's number as seed.
    """

    table: str
    what: str
    badge: Badge
    wish: Wish
    paper: str = ""

    @property
    def group(self) -> str:
        """Names the row in the list of films."""
        return f"{self.table}, {self.wish.distance_m:g} m"


def conditions(*, quick: bool) -> Iterator[Condition]:
    """All rows; quick: two distances of each rendering."""
    mask = board(Lens("mask", LENS_PITCH_MM, GAP_MM, 1.0), page_mm=140.0, marker_mm=24.0, corner_mm=14.0)
    prototype = board(Lens("lenticular", LENS_PITCH_MM, GAP_MM, 1.56), page_mm=146.0, marker_mm=26.0, corner_mm=18.0)
    for table, what, badge in (("rendering 1", "two layers", mask), ("rendering 2", "lens sheet", prototype)):
        for distance in DISTANCES_M[::6] if quick else DISTANCES_M:
            wish = replace(SWEEP, distance_m=distance)
            yield Condition(table, f"{what}, one sweep", badge, wish)
    for table, what, motion, paper in (
        ("A", "hand-held", "handheld", ""),
        ("B", "turned in the picture", "roll", "0.76 to 0.81"),
        ("C", "from 45 degrees", "oblique", "0.72"),
        ("D", "all turns at once", "tumble", "0.57 to 0.67"),
    ):
        yield Condition(table, what, prototype, Wish(motion, 1.2, 180, 30.0), paper)


def board(lens: Lens, *, page_mm: float, marker_mm: float, corner_mm: float) -> Badge:
    """A square board of one uniform field as the published ones are; corner_mm: from an edge to a marker's centre."""
    low = (page_mm - FIELD_MM) / 2
    rect = (low, low, low + FIELD_MM, low + FIELD_MM)
    field = Grating(rect, "x", LINE_PITCH_MM, "uniform", (Cell(rect, LINE_PITCH_MM, low, 0.5),))
    a, b = corner_mm, page_mm - corner_mm
    markers = Markers("DICT_4X4_50", marker_mm, (0, 1, 2, 3), ((a, a), (b, a), (b, b), (a, b)))
    return Badge(None, "Published board", (page_mm, page_mm), lens, (field,), markers)
