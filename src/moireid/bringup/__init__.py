"""The first badge: from an empty folder to a badge whose sheet, printer, camera and assembly are known.

build_folder.py    the folder: what is wished, which pictures and films are there, and what was read of them
chart_steps.py     print the pitch test, read it, calibrate the camera
badge_steps.py     print the badge, film it twice
film_figures.py    what two films say about the badge as it was built
field_crops.py     the fringe fields of some frames, and nothing else of a film
capture_record.py  films as signals and crops, to be shared
bring_up.py        the steps in their order: what can be done is done, and what comes next is said
sealed_steps.py    a step that reads films, done by a sealed process in a folder of its own
progress_page.py   all of it as one page
"""
