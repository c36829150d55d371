"""Which attacks by a reader of this code are accepted.

cases.py          the attacks, and true films on their trajectories
photographs.py    a table of photographs as fringes
motions.py        sweeps, views in turns, gaps, steps
edits.py          moved markers
forgers_suite.py  the forgers suite
"""
