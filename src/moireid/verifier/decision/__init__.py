"""One decision from one list of tests (`judge.py`).

judge.py       the motion invariant: the list of tests, and the verdict from them; also for each few seconds
doubts.py      what may make the film of a true badge look forged: it widens the rooms of the tests beforehand
figures.py     correlation, gain, error bars of one grating; calibrated odds
sheet_gain.py  which gains this badge's sheet may have
comparison.py  the table of explanations: the law's residual, and each rival's odds and share
parts.py       do the parts of the badge move as one?
photographs.py do the fringes' spacing and shape follow the law, too?
findings.py    the other findings, as sentences
"""
