"""Photographs of the badge instead of the badge: phases that the law prescribes do not show them, other figures do.

The picture of a badge with one axis depends on one parallax, and weakly on distance.  So a forger with some photographs
can show, in each frame, the phase that the law asks for.  What photographs cannot do as well:

fringe_spacing.py  the spacing of the fringes follows the distance; what cross-faded photographs show
cross_fade.py      two to four photographs, shown in turn or cross-faded, bend the waveform in a form of their own
third_harmonic.py  in superposed photographs the third harmonic does not turn with the fringes
"""
