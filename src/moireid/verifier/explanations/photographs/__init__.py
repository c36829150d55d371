"""Could the film show photographs of the badge instead of the badge?

count.py           the findings, and how many photographs such a film takes
spacing.py         the spacing of the fringes against the distance
ripple.py          how much the waveform changes from place to place
cross_fade.py      the form that two to four cross-faded photographs leave in the waveform
third_harmonic.py  the part of the third harmonic that turns with the fringes
photo_sampling.py  where photographs would be taken, and what they show between
exposure_blur.py   what a long exposure does to a waveform
"""
