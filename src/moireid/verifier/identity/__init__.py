"""Whose badge is it, and is it the one that was enrolled?

cell_phase.py  phases of the cells                  waveform.py       the shape of a fringe
decode.py      the identity, and the claim          compare_built.py  original or copy
row_slip.py    do the code's rows move with the plain rows?
"""
