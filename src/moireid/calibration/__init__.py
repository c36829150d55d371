"""What a lens sheet is, read from pictures of a pitch test.

still.py     a photograph, or the mean of a film's first frames
chart.py     the bands of a pitch test sheet, read from a picture
lens_fit.py  the sheet's pitch, from the bands' beats
"""
