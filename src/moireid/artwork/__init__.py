"""What a badge shows apart from fringes and markers: lines of text, pictures and colours, placed by a template.

It is no part of the `Badge`: nothing here enters a verdict, and nothing here may cover what the verifier reads.

content.py   what one badge shows: lines, logo, portrait, colour
pictures.py  PNG and JPEG files, checked and loaded; the QR code of an id
svg.py       SVG files, checked and drawn
colours.py   colours by name, and which letters can be read on them
template.py  template files, read and checked
templates/   the templates that come with the program
clear.py     the parts of a board that must stay clear, and its free areas
placing.py   template, badge and content → pieces with their places; notes about content that is not shown
columns.py   the columns of a list of people that say how each badge looks
"""
