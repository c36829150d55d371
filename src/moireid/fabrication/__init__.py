"""From a Badge to the files that a person prints, cuts and assembles.

process_figures.py  figures of printer, laser and card: fits, kerf, plates on sale
sight.py            what a camera must see of the badge, and a check that no part of a mount hides it
solids.py           checks of every STEP and STL file after writing
meshes.py           3MF files; checks of interference, walls and overhangs
page/               the printed page, the pitch test sheet and the preview
printed/            the mount to 3D-print
acrylic/            the mount to laser-cut
assembly/           assembly.pdf: how the parts go together
parts.py            which mounts can be made for a badge, and which are left out
package.py          all files of one badge, planned before and checked after
event.py            sheets and folders for many people
"""

from typing import TYPE_CHECKING

from moireid.lazy import lazy

if TYPE_CHECKING:
    from moireid.fabrication.event import Event, print_event
    from moireid.fabrication.package import PrintResult, print_badge
    from moireid.fabrication.page.pdf import write_badge_pdf

__all__ = [
    "Event",
    "PrintResult",
    "print_badge",
    "print_event",
    "write_badge_pdf",
]

__getattr__ = lazy(
    __name__,
    {
        "Event": "event",
        "PrintResult": "package",
        "print_badge": "package",
        "print_event": "event",
        "write_badge_pdf": "page.pdf",
    },
)
