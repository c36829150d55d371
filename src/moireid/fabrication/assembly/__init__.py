"""assembly.pdf: how the parts go together.

words.py       what it says
sketches.py    a picture a step
exploded.py    the parts, moved apart
axonometry.py  drawn from a corner
guide.py       the pages
"""
