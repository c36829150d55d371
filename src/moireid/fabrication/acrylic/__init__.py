"""The mount to laser-cut.

plates.py      base, frame, cover and the film between, as closed paths of lines and arcs
drawings.py    what is cut, and acrylic.dxf and acrylic.svg: written and read back
"""
