"""Explanations of one film's fringes: the law of optics, and its rivals, each a small model of the same evidence.

honest.py     the law, with what an honest camera, badge and codec may add to it
rivals.py     rivals over the whole film and for a while, and how often one would look law-like
table.py      the table's rows, the cause, and odds in words
strength.py   how few forgeries that know nothing of the law would look as law-like, by bounds that hold at any draw
words.py      what the fringes do by each explanation, in words
residuals.py  size of a residual, its independent samples, and odds
photographs/  photographs of the badge instead of the badge
"""
