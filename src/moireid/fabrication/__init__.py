"""From a Badge to the files that a person prints, cuts and assembles.

process_figures.py  figures of printer, laser and card: fits, kerf, plates on sale
sight.py            what a camera must see of the badge, and a check that no part of a mount hides it
solids.py           STL and 3MF files, each checked after writing; interference, walls and overhangs
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
