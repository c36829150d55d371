"""Do the fringes follow the law?

figures.py        the figures of one grating                likelihood.py   genuine or forged: the likelihood ratio
judge.py          the motion invariant                      segments.py     the verdict by time
steady_course.py  would a drift or a delay show here?       photographs.py  could this be a table of photographs?
sheet_gain.py     the gain that this badge's sheet has      excuses.py      what a hand, a camera, an editor may cause
spacing.py        does it follow the distance?              ripple.py       does the waveform change with the place?
taken_places.py   where a forger would take photographs     cross_fade.py   does it change as that of few photographs?
turning.py        does the third harmonic turn with them?   long_exposure.py  what a quick badge loses of it
"""
