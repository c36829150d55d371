"""The two layers of a badge: the lens in front, and the lines printed behind it.

Convention: lengths in mm; page coordinates and rectangles as in `badge`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Meta

from moireid.errors import SpecError
from moireid.frames import Axis, Coordinate, Rect

Pitch = Annotated[float, Meta(ge=0.01, le=20)]
Share = Annotated[float, Meta(gt=0, lt=1)]
Thickness = Annotated[float, Meta(gt=0, le=100)]
Blend = Annotated[float, Meta(ge=0, le=100)]
Bits = Annotated[int, Meta(ge=1, le=128)]


@dataclass(frozen=True)
class Lens:
    """The front layer: a lenticular sheet, or a line mask on clear film."""

    kind: Annotated[Literal["lenticular", "mask"], Meta(description="which of the two")]
    pitch_mm: Annotated[Pitch, Meta(description="from one lens, or line of a mask, to the next")]
    thickness_mm: Annotated[Thickness, Meta(description="from the top of the lenses, or from the mask, to the page")]
    refractive_index: Annotated[float, Meta(ge=1, le=3, description="of the sheet; 1 for air")]
    radius_mm: Annotated[
        Thickness | None,
        Meta(description="radius of a lens; if it is missing, the one that focuses on the page; a mask has none"),
    ] = None
    open_fraction: Annotated[
        Share | None, Meta(description="share of a mask that is clear, one half if it is missing; a lens has none")
    ] = None

    def __post_init__(self) -> None:
        if self.kind == "mask":
            object.__setattr__(self, "open_fraction", 0.5 if self.open_fraction is None else self.open_fraction)
            return
        if self.refractive_index <= 1.0:
            raise SpecError(
                f"lens refractive_index={self.refractive_index:g} cannot focus; a lenticular sheet has more than 1"
            )
        if self.radius_mm is None:
            # A lenticular sheet for print focuses on its flat back: R = g (n - 1) / n, the paraxial thick-lens formula.
            focus_on_back_mm = self.thickness_mm * (self.refractive_index - 1.0) / self.refractive_index
            object.__setattr__(self, "radius_mm", focus_on_back_mm)
        assert self.radius_mm is not None
        least_mm = self.pitch_mm / 2
        if self.radius_mm < least_mm:
            thicker_mm = self.thickness_mm * least_mm / self.radius_mm
            finer_mm = math.floor(1e4 * self.radius_mm * self.pitch_mm / least_mm) / 1e4
            raise SpecError(
                f"lens radius_mm={self.radius_mm:.4g} is below half the pitch ({least_mm:.4g} mm), so the lenses would "
                f"not meet; raise thickness_mm to {math.ceil(1e3 * thicker_mm) / 1e3:g} or more, or "
                f"give a pitch of {finer_mm:g} mm or less",
                most_pitch_mm=finer_mm,
            )


@dataclass(frozen=True)
class Cell:
    """A part of a grating with one pitch: dark lines begin at edge_mm + k pitch_mm and are duty * pitch_mm wide."""

    rect_mm: Rect
    pitch_mm: Annotated[Pitch, Meta(description="from one line to the next, as drawn on the printer's dots")]
    edge_mm: Annotated[
        Coordinate,
        Meta(description="where a dark line begins along the axis; the others begin whole pitches from it"),
    ]
    duty: Annotated[Share, Meta(description="share of the pitch that is dark")]
    blend_mm: Annotated[
        tuple[Blend, Blend],
        Meta(
            description="how far from its borders its lines pass into those of the neighbours, along the axis and "
            "along the lines (`moireid.smooth_lines`); missing where they end at the border"
        ),
    ] = (0.0, 0.0)


@dataclass(frozen=True)
class Code:
    """How a grating's cells carry an identity; the family's module in `idcodes` defines the meaning.

    Roles are "reference" (uniform, read first), "beat" (uniform, read by its beat frequency relative to the reference)
    and "phase" (lines shifted by a share of the pitch).  A beat level L has the signed design frequency
    base_frequency_per_mm + L frequency_step_per_mm, cycles per mm of page, for L below `levels`.
    """

    roles: Annotated[
        tuple[Literal["reference", "beat", "phase"], ...],
        Meta(min_length=1, max_length=10000, description="what each cell is for, in order"),
    ]
    payload_bits: Annotated[Bits, Meta(description="length of the identity, which the whole badge carries")]
    levels: Annotated[int, Meta(ge=2, le=256, description="how many beats there are to choose from")]
    base_frequency_per_mm: Annotated[float, Meta(ge=-2, le=2, description="beat of level 0, in cycles a mm, signed")]
    frequency_step_per_mm: Annotated[
        float, Meta(ge=-1, le=1, extra_json_schema={"not": {"const": 0}}, description="from one level to the next")
    ]
    reference_level: Annotated[
        Annotated[int, Meta(ge=0, le=255)] | None,
        Meta(description="level of the reference cells; missing if it is part of the identity"),
    ] = None
    phase_levels: Annotated[
        Annotated[int, Meta(ge=2, le=64)] | None,
        Meta(description="how many shifts of lines, in a full turn, there are to choose from"),
    ] = None

    @property
    def reference_cell(self) -> int:
        """Index of the reference cell nearest to the middle of the list."""
        places = [index for index, role in enumerate(self.roles) if role == "reference"]
        return places[len(places) // 2]


@dataclass(frozen=True)
class Grating:
    """Printed lines under one piece of lens sheet.

    Convention: `moireid.frames`.
    """

    rect_mm: Rect
    axis: Annotated[
        Axis,
        Meta(
            description="the direction of motion that its fringes sense, across the lines; a number is an angle in "
            "degrees from x towards y, and then the rectangles of the grating and of its cells lie in the page's frame "
            "turned by that angle about the page's centre"
        ),
    ]
    pitch_mm: Annotated[Pitch, Meta(description="its usual distance from one line to the next")]
    family: Annotated[
        str,
        Meta(
            min_length=1,
            max_length=40,
            description="how it carries an identity: `spacing`, `pitch`, or `uniform` for none",
        ),
    ]
    cells: Annotated[
        tuple[Cell, ...],
        Meta(min_length=1, max_length=10000, description="its patches, each with lines of one pitch and place"),
    ]
    code: Annotated[
        Code | None, Meta(description="how the identity is laid over the cells; missing where there is none")
    ] = None

    def __repr__(self) -> str:
        """Short, without the cells."""
        return f"Grating(axis={self.axis!r}, pitch_mm={self.pitch_mm:g}, {self.family}, {len(self.cells)} cells)"


def is_smooth(grating: Grating) -> bool:
    """Whether any of its cells blends with its neighbours."""
    return any(any(cell.blend_mm) for cell in grating.cells)
