"""The published pipeline (Qing et al., 2026), a baseline: every collection of films is scored by it too.

`moireid verify --pipeline published` and `--corners` find this package by its entry point (group `moireid.pipelines`).

pipeline.py  its verdict by the correlation of fringe phase and camera place
corners.py   the region's corners, given by hand and tracked between frames
"""

from moireid_lab.baseline.corners import corners_from, without_corners
from moireid_lab.baseline.pipeline import verify_published

__all__ = ["corners_from", "verify_published", "without_corners"]
