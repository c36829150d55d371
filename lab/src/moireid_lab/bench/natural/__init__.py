"""True badges filmed with measured motions: does a longer part of a film decide more than a shorter one?

cases.py   motions and distances   film_parts.py   a film's parts, and its track cut to one
suite.py   filmed and judged       output.py       table and plot
"""
