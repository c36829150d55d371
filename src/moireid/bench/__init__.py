"""`moireid bench SUITE`: figures with the command that prints them; this room may use all others, as the programs do.

identity.py   does the whole identity come back, over distance, printing and assembly; original or copy?
matching.py   false matches at symbol level, by an error model fitted to the films of `identity`
calibration.py  photographs of the pitch test sheet, read back
simulate.py   error against run time of the renderers; reference.py: the outside tracer, scenes.py: eleven scenes
output.py     table, JSON and plot of a suite
"""

SUITES = ("identity",)
