"""assembly.pdf: how the parts go together.

assembly_words.py  its text: what to have, how to print, the steps
sketches.py        the small picture of each step, fringes included
moving_looks.py    fringes.webp: how fringes run as a head moves
exploded.py        draws the exploded views; card and sheet in them
solid_views.py     solids as line drawings
mount_views.py     the parts of mounts in the views
guide.py           the pages: page 1 (lists), page 2 (steps), the sheet in true size, exploded views
"""
