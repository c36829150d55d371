"""Printing time and plastic of each mount, written by `benchmarks/mounts.py --table`, which says how.

The whole mount, clip or stand included: PLA, a nozzle of 0.4 mm, layers of 0.2 mm, three outlines, and the speeds that
PrusaSlicer has without a printer's profile.
"""

#: Minutes and grams, by format and kind of the printed mount.
PRINTING_TIMES: dict[tuple[str, str], tuple[int, float]] = {
    ("4x3in", "lanyard"): (35, 6.6),
    ("4x3in", "clip"): (51, 9.2),
    ("4x3in", "stand"): (54, 9.2),
    ("4x3in", "holder"): (35, 6.3),
}
