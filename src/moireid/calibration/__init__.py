"""The pitch of a lens sheet, measured from pictures of a pitch test, its thickness, from a film of it; the growth of
lines in print; and a camera.

still.py          a photograph, or some of the first frames of a film
chart_reading.py  the chart in a picture: the camera's position, and the brightness of its bands
bands.py          the lens's line frequency, estimated from each band
lens_fit.py       the sheet's pitch, from the estimates of all bands
thickness.py      the sheet's thickness, from the motion of the fringes
ink_reading.py    by how much the printer widens lines, from the strip on the chart
sheet_reading.py  all of these from one photograph or film
camera_fit.py     a camera, from a film of the camera chart
film_orders.py    sheet and camera, read by a sealed process
"""
