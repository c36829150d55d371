"""The published pipeline (Qing et al., 2026), a baseline: every collection of films is scored by it too.

pipeline.py  its verdict by the correlation of fringe phase and camera place
corners.py   the region's corners, given by hand and tracked between frames
"""
