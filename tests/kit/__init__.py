"""What several tests need; no test file imports another.

places.py         where the project, its films and its examples lie
drawn_pages.py    pictures of a page whose homography is known        coded_films.py     films of given pictures
numeric_films.py  tracks of a badge, made of numbers alone            rendered_frames.py frames by either renderer
drawn.py          the shapes on a PDF page                            mounting.py        mounts, and what a camera sees
film_stubs.py     jobs that stand in for films                        report_faults.py  a report held against its schema
guiding.py        the blocks of a guide, typed                        portrait.py        a person with a badge
registries.py     registries on SQLite and PostgreSQL                 webbing.py         a visit to the studio
"""
