"""What a lens sheet is, read from pictures of a pitch test.

still.py     a photograph, or some of the first frames of a film
chart.py     the chart in a picture: the camera's place, and the brightness of its bands
bands.py     the lens's line frequency that each band shows
lens_fit.py  the sheet's pitch, from the bands' beats
"""
