"""One decision from one table of explanations.

figures.py     correlation, gain, error bars of one grating; calibrated odds
sheet_gain.py  which gains this badge's sheet may have
comparison.py  the table of explanations: the law's residual, and each rival's odds and share
findings.py    the findings that are reported, as sentences
judge.py       the motion invariant: the verdict from all of that, also for each few seconds
"""
