"""What a badge wears besides what is read: lines, pictures, colour, and the template that says where they stand.

It is no part of the `Badge`: nothing here enters a verdict, and nothing here may touch what the verifier reads.

content.py   what one person wears: lines, logo, portrait, colour
pictures.py  PNG and JPEG files, checked and loaded
svg.py       SVG files, checked and drawn
colours.py   colours by name, and what is read on them
template.py  template files, read and checked
templates/   those that come with the program
clear.py     what of a board stays clear, and its free areas
placing.py   template, badge and content → pieces with their places
columns.py   what a list of people says of their looks
"""
