"""The mount to laser-cut.

contour.py   closed paths of lines and arcs, moved by half a kerf
plates.py    base, frame and cover, as outlines
cutting.py   what is cut: kerf, layers, scale (no file)
drawings.py  acrylic.dxf and acrylic.svg: the drawing written and read back
stack.py     the plates put together, and stack.glb
"""
