"""Error against run time of the verifier.

suite.py   the sweep                                      films.py            films whose truth is known
judged.py  frames in, verdict out                         motion_extremes.py  stiff and extreme motions
output.py  tables and plots
"""
