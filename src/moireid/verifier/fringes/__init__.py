"""The phase of the fringes, measured and predicted.

sinusoid.py        least squares of a fringe on a background
mixed_frames.py    are frames mixed with their neighbours?
phase_coverage.py  how much of their way does a film show?
beyond_phase.py    all of that, frame by frame
signals.py         both phases of each grating over the film
"""
