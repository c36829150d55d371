"""One decision from one table of explanations.

figures.py     correlation, gain, error bars of one grating
sheet_gain.py  which gains this badge's sheet may have
comparison.py  the table: what the law leaves, and each rival's odds and share
findings.py    what of it is reported, in sentences
judge.py       the motion invariant: all of it together
"""
