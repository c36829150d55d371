"""From a Badge to the files that a person prints, cuts and assembles.

process.py   what printer, laser and card ask for: fits, kerf, plates on sale
sight.py     what a camera must see of the badge, and what stands in its way
solids.py    checks of every STEP and STL file after writing
meshes.py    3MF, interference and walls
page/        the printed page, the pitch test sheet and the preview
printed/     the mount to 3D-print
acrylic/     the mount to laser-cut
assembly/    assembly.pdf: how the parts go together
parts.py     what of a mount can be made of a badge, and what was left out
package.py   all files of one badge, planned before and checked after
event.py     sheets and folders for many people
"""
