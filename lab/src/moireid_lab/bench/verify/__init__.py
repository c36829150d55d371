"""Error against run time of the verifier.

films.py         films whose truth is known
verify_suite.py  the verify suite, with its table and plot
"""
