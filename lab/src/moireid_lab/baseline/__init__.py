"""The published pipeline (Qing et al., 2026), a baseline: every collection of films is scored by it too.

`moireid verify --pipeline published` finds this package by its entry point (group `moireid.pipelines`).

pipeline.py  its verdict by the correlation of fringe phase and camera place
corners.py   the region's corners, given by hand and tracked between frames
"""

from moireid_lab.baseline.pipeline import verify_published

__all__ = ["verify_published"]
