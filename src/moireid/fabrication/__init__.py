"""From a Badge to the files that a person prints, cuts and assembles.

process_figures.py  figures of printer, laser and card: fits, kerf, plates on sale
sight.py            what a camera must see of the badge, and a check that no part of a mount hides it
solids.py           STL and 3MF files, each checked after writing; interference, walls and overhangs
dxf_file.py         drawings for a cutter as DXF
text/               words of any script as glyphs, in a PDF and in a picture
page/               the printed page, the pitch test sheet and the preview
printed/            the mount to 3D-print
acrylic/            the mount to laser-cut
assembly/           assembly.pdf: how the parts go together
part_colours.py     colours of the parts of a mount
solid_parts.py      the parts of a mount as build123d solids in their places, and a check of these
assembly_files.py   a mount put together: mount.step, acrylic.step and mount.glb
mount_parts.py      which mounts can be made for a badge, their solids and files
package.py          all files of one badge, planned before and checked after
event.py            sheets and folders for many people
shopping/           what to buy for badges, and how lens sheets are cut
"""

from typing import TYPE_CHECKING

from moireid.lazy import lazy

if TYPE_CHECKING:
    from moireid.fabrication.event import print_event as print_event
    from moireid.fabrication.package import PrintResult as PrintResult
    from moireid.fabrication.package import print_badge as print_badge
    from moireid.fabrication.page.pdf import write_badge_pdf as write_badge_pdf
    from moireid.fabrication.solid_parts import mount_solids as mount_solids

HOMES = {
    "PrintResult": "package",
    "mount_solids": "solid_parts",
    "print_badge": "package",
    "print_event": "event",
    "write_badge_pdf": "page.pdf",
}
__all__ = [*HOMES]
__getattr__ = lazy(__name__, HOMES)
