"""The published pipeline (Qing et al., 2026), kept as a baseline: every collection is scored by it too.

pipeline.py   its verdict by the correlation of fringe phase and camera place
corners.py    corners given by hand, tracked between frames
"""
