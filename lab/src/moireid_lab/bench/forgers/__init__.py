"""What an attacker who reads this code gets past it, and what happens to honest films that are spoilt.

cases.py          the attacks and the mishaps
photographs.py    a table of photographs as fringes
motions.py        sweeps, views in turns, cuts and gaps
reposed.py        photographs on a course that nobody chose
edits.py          hands, captions, moved markers
forgers_suite.py  table and plot of the forgers suite
"""
