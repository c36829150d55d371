"""The first badge: from an empty folder to a badge whose sheet, printer, camera and assembly are known.

build_folder.py    the folder: what is wished, which pictures and films are there, and what was read of them
chart_steps.py     print the pitch test, read it
badge_steps.py     print the badge, film it twice
film_figures.py    what two films say about the badge as it was built
bring_up.py        the steps in their order: what can be done is done, and what comes next is said
"""
