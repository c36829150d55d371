"""Error against run time of the renderers.

reference.py       an independent tracer
scenes.py          eleven scenes
simulate_suite.py  the simulate suite, with its table
"""
