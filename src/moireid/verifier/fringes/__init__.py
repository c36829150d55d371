"""The phase of the fringes, measured and predicted.

predicted_phase.py   the phase by the optics              sinusoid.py      least squares of a fringe on a background
strip_phase.py       beat frequency and phase of one row  strip_shape.py   the shape of a row's fringes
block_motion.py      do the parts of a row move alike?    depth_law.py     does their spacing follow the distance?
mixed_frames.py      are frames mixed with their neighbours?
phase_coverage.py    how much of their way does a film show?
beyond_phase.py      all of that, frame by frame          unwrap.py        phase without jumps of a turn
signals.py           both phases of each grating over the film
"""
