"""The parts of a mount as solids, for CAD programs that Python drives.

Convention: the frame of `sight`, mm; each part is in its place in use.
"""

from __future__ import annotations

from typing import Any

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication.process_figures import MountFigures

#: The mount to laser-cut, besides the kinds of the printed one.
ACRYLIC = "acrylic"


def mount_solids(badge: Badge, mount: str = "lanyard", figures: MountFigures | None = None) -> dict[str, Any]:
    """Make the parts of a mount, as `print_badge` writes them to files.

    Parameters
    ----------
    badge : Badge
        What the mount holds.
    mount : str
        A kind of the printed mount, "lanyard", "clip", "stand" or "holder"; or "acrylic" for the stack to laser-cut,
        with page, sheet and screws.
    figures : MountFigures, optional
        Of printer and laser; None for the defaults.

    Returns
    -------
    dict of str to build123d.Shape
        Each part in its place in use, by its name, which is its label too; with its colour.

    Raises
    ------
    FabricationError
        Where no such mount fits the badge, or there is none of that name.
    MissingExtraError
        Without the CAD packages.

    Notes
    -----
    Convention: the board's middle is the origin, x right, y up, z towards the viewer, mm.
    """
    from moireid.fabrication.acrylic.plates import plan_acrylic
    from moireid.fabrication.acrylic.stack import COLOURS
    from moireid.fabrication.acrylic.stack_step import stack_parts
    from moireid.fabrication.printed.mount import KINDS, mount_bodies
    from moireid.fabrication.solids import cad_package

    if mount not in (*KINDS, ACRYLIC):
        raise FabricationError(f"mount {mount!r} is not known; choose one of {', '.join((*KINDS, ACRYLIC))}")
    figures = figures or MountFigures()
    b3d = cad_package("build123d")
    if mount == ACRYLIC:
        # Both packages hold shapes of the same kernel.
        cut = stack_parts(cad_package("cadquery"), plan_acrylic(badge, figures.acrylic))
        solids = {name: b3d.Solid(part.wrapped) for name, part in cut.items()}
    else:
        solids = {body.name: body.used for body in mount_bodies(badge, mount, figures.printed)}
    for name, solid in solids.items():
        solid.label, solid.color = name, b3d.Color(*(value / 255 for value in COLOURS[name.split("-")[0]]))
    return solids
