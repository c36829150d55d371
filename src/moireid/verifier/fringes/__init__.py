"""The phase of the fringes, measured and predicted.

strip_law.py       the phase that the optics predict along one strip
strip_phase.py     frequency and phase of one strip, measured
strip_shape.py     the shape of its fringes, and whether all places of a strip move alike
uneven_air.py      rows and places that move a little further, as there is more air beneath the sheet
place_map.py       what stays the same in all frames: lenses that are not where they should be
all_strips.py      all strips of a track, measured with the maps
grating_signal.py  the signal of one grating: both phases, and what else the film shows of it
signals.py         from the track to the signals of all gratings
sinusoid.py        least squares of a fringe on a background; unwrapping
mixed_frames.py    are frames mixed with their neighbours?
beyond_phase.py    spacing against distance, and the third harmonic
"""
