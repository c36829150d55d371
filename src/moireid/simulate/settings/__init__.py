"""Where a badge is filmed: on a desk, worn, at a lectern, in a call; in colour, every part drawn by the project.

drawn_layers.py  shapes in millimetres on a picture
wearing.py       what belongs to the badge: print, holder, cord, and the person who wears it
places.py        walls, stage, desk and lectern, and the settings by name
painting.py      flat pictures at their depths, as the camera sees them
"""
