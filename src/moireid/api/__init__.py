"""What `import moireid as mo` offers: the work of the commands for notebooks and programs, on objects.

making.py      design and print a badge
checks.py      is the badge in a film real, and whose is it?
film_check.py  a film judged, and the outcome as text, page, arrays and plot
asking.py      how a registry, a bundle or a file is asked
places.py      a registry by path or URL

`mo.simulate` is in `simulate`, and `mo.mount_solids` in `fabrication`.
"""
