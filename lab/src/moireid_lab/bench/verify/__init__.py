"""Error against run time of the verifier.

films.py            films whose truth is known
motion_extremes.py  stiff and extreme motions
verify_suite.py     the verify suite, with its table and plot
"""
