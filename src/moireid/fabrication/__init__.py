"""From a Badge to the files that a person prints, cuts and assembles.

artwork.py   the page's shapes in mm: dark lines, markers, crop marks, scale bars
page.py      badge.pdf: the page at true scale
chart.py     the pitch test sheet: its page with numbers, and its description
preview.py   preview.png: the board as a camera 1 m away sees it
assembly.py  assembly.pdf: parts and steps
mount.py     the printed mount, STEP and STL
solids.py    checks of every solid and mesh after writing
package.py   all files of one badge, planned before and checked after
"""
