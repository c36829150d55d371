"""Explanations of one film's fringes: the law of optics, and its rivals, each a small model of the same evidence.

series.py      phases over time, as explanations are compared on them
honest.py      the law, with what an honest camera, badge and codec may add to it
rivals.py      whole-film rivals: still, drift, late, place, another gain, a motion of its own
spells.py      fringes that leave the law for a while
likelihood.py  rivals that contain the law: wander on top, rows or places on clocks of their own
lookalikes.py  how often would a rival look as law-like as this film?
residuals.py   size of a residual, its independent samples, and odds
photographs/   photographs of the badge instead of the badge
"""
