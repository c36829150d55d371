"""The mount to laser-cut.

contours.py    closed paths of lines and arcs, and kerf
plates.py      base, frame, cover and the film between
drawings.py    what is cut, and acrylic.dxf and acrylic.svg: written and read back
"""
