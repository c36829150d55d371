"""The phase of the fringes, measured and predicted.

phase.py           measured phase and waveform of one strip, and the phase that the optics predict
signals.py         both phases of each grating over the film
sinusoid.py        least squares of a fringe on a background; unwrapping
mixed_frames.py    are frames mixed with their neighbours?  do all places of a strip move alike?
phase_coverage.py  which share of the fringe phases does a film show?
beyond_phase.py    spacing against distance, and the third harmonic
"""
