"""Which attacks by a reader of this code are accepted, and what happens to honest films that are spoilt.

cases.py          the attacks and the mishaps
photographs.py    a table of photographs as fringes
motions.py        sweeps, views in turns, cuts and gaps
edits.py          hands, captions, moved markers
forgers_suite.py  the forgers suite, with its table and plot
"""
