"""assembly.pdf: how the parts go together.

words.py      what it says         sketches.py  a picture a step       fringes.py     what a badge looks like
plate.py      pieces in true size  exploded.py  the parts, moved apart  axonometry.py  drawn from a corner
guide.py      the pages
"""
