"""The published pipeline, kept as a baseline: every collection is scored by it too.

published.py  its verdict by the correlation of fringe phase and camera place
corners.py    corners given by hand, tracked between frames
"""
