"""What to buy for an event, and how to cut it.

cutting.py        pieces of lens sheet on whole sheets, by cuts from edge to edge
mount_times.py    hours and grams of each printed mount, as a slicer found them
needs.py          from a badge and a number of people to the lines of a shopping list
list_files.py     shopping-list.csv and shopping-list.pdf
plan_files.py     cutting-plan.pdf and cutting-plan.dxf, read back and checked
written.py        all of these files, or none
"""
