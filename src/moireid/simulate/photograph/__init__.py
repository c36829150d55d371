"""A photograph of a badge as it is worn, path-traced in colour: for pages and slides, and no evidence of anything.

surfaces.py    surfaces as grids of points: tubes, plates with rounded corners, cloth
worn_badge.py  holder, hook, cord and cloth around a badge, as Mitsuba's surfaces
photograph.py  camera, light and passes; the picture with its noise
"""
