"""Rays traced in closed form through the true lenses, only where the badge is.

analytic_renderer.py  frames of a scene
rows.py               the loop over pixels
quick.py              most pixels, many rays at once
trace.py              the rest, ray by ray in float64
traced_sheet.py       the lens sheet, and a ray through it
traced_page.py        what is printed, as tables
uneven_sheet.py       what changes over the sheet: places of lenses, air
page_light.py         bands, haze, and light from one side
light_kernels.py      what a light adds
accuracy.py           how far one picture is from another, in radians
"""
