"""The mount to laser-cut.

contours.py    closed paths of lines and arcs, and kerf
plates.py      base, frame, cover and the film between
drawings.py    what is cut, as DXF and SVG, all plates and each stock: written and read back
"""
