"""The printed page.

artwork.py  its shapes in mm: lines, markers, crop marks, scale bars    lettering.py  names of any script
pdf.py      badge.pdf, the page at true scale                           chart.py      the pitch test sheet
dress.py    what a badge wears, on the page                             words.py      words set in a room
preview.py  preview.png, the board as a camera 1 m away sees it         paint.py      what it wears, there
worn.py     preview.webp, the finished badge as worn, which moves
"""
