"""Whose badge is it, and are its figures those of enrolment?

cell_phase.py       phases of the cells
neighbour_lines.py  what neighbours add to a cell where lines pass into each other
cell_slip.py        do the cells move with the plain rows, and how far?
cell_waveform.py    the shape of a fringe
page_scale.py       is the page off its size, or the sheet off its pitch?
decode.py           the identity, and the claim
compare_built.py    are the figures those of enrolment?
"""
