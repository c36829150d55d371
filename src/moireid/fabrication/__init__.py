"""From a Badge to the files that a person prints, cuts and assembles.

artwork.py   the page's shapes in mm: dark lines, markers, crop marks, scale bars
page.py      badge.pdf: the page at true scale
chart.py     the pitch test sheet: its page with numbers, and its description
preview.py   preview.png: the board as a camera 1 m away sees it
assembly.py  assembly.pdf: parts, steps, exploded views; exploded.py has their parts, axonometry.py draws them
process.py   what printer, laser and card ask for: fits, kerf, plates on sale
sight.py     what a camera must see of the badge, and what stands in its way
tray.py      the printed tray that holds page and lens sheet
holders.py   lanyard, clip and stand
mount.py     the printed mount, STEP, STL and 3MF
contour.py   closed paths of lines and arcs, moved by half a kerf
acrylic.py   base, frame and cover to laser-cut, as outlines
cutting.py   the laser's drawing: kerf, layers, scale; dxf.py and svg.py write and check it
stack.py     the acrylic stack put together, and stack.glb
solids.py    checks of every STEP and STL file after writing
meshes.py    3MF, interference and walls
parts.py     what of a mount can be made of a badge, and what was left out
package.py   all files of one badge, planned before and checked after
"""
