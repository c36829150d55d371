"""The options of `print-your-badge` about the mount, gathered into one `MountWish`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from moireid.cli.common import FiniteRange
from moireid.cli.printing.gathering import gathered
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.fabrication.process import MountFigures


@dataclass(frozen=True)
class MountWish:
    """What was asked for; None where nothing was."""

    mount: str | None
    kerf_mm: float | None
    base_mm: float | None
    mount_pairs: tuple[str, ...]

    def figures(self, *, for_many: bool) -> MountFigures:
        """The figures of printer and laser; for_many: whether there is no mount where none was asked for.

        Raises: SpecError for figures of no mount, or of none that is known.
        """
        from moireid.fabrication.process import mount_figures

        given = {"kerf_mm": self.kerf_mm, "base_mm": self.base_mm}
        pairs = [*self.mount_pairs, *(f"{key}={value}" for key, value in given.items() if value is not None)]
        without = self.mount == "none" or (self.mount is None and for_many)
        # An adhesive holds page and sheet together where no mount does.
        if without and any(not pair.strip().startswith("adhesive_mm") for pair in pairs):
            raise SpecError(
                "--kerf, --acrylic and --mount-figure are figures of a mount; give --mount lanyard, clip, stand or "
                "holder with them, or leave them out (adhesive_mm alone goes without a mount)"
            )
        return mount_figures(pairs)


mount_options = gathered(
    "wish",
    MountWish,
    [
        click.option(
            "--mount",
            type=click.Choice(["lanyard", "clip", "stand", "holder", "none"]),
            show_default="lanyard; with --people none",
            help="What holds the badge; it comes as parts to 3D-print and as an acrylic stack to laser-cut. Into a "
            "holder a finished badge is pressed.",
        ),
        click.option(
            "--kerf",
            "kerf_mm",
            type=FiniteRange(0, 1),
            show_default="0.15",
            metavar="MM",
            help="Width of the laser's cut; 0 if the shop corrects for it.",
        ),
        click.option(
            "--acrylic",
            "base_mm",
            type=FiniteRange(2, 10),
            show_default="3",
            metavar="MM",
            help="Thickness of the acrylic base plate.",
        ),
        click.option(
            "--mount-figure",
            "mount_pairs",
            multiple=True,
            metavar="NAME=MM",
            help="Another dimension of the mount, such as card_mm=0.5; may be given several times.",
        ),
    ],
)
