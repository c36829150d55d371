"""assembly.pdf: how the parts go together.

assembly_words.py  its text: what to have, how to print, the steps
sketches.py        the small picture of each step, fringes included
exploded.py        the parts of the exploded views, as prisms
axonometry.py      draws the exploded views, and the lens sheet in true size
guide.py           the pages: page 1 (lists), page 2 (steps), exploded views
"""
