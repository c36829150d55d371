"""The printed page.

canvas.py      the canvas of every PDF, in mm
lettering.py   which letters of a name are printed here, and what is said of the others
line_breaks.py where words break into rows, and how a word that is too long is divided
page_words.py  size and rows of words in a given room
pdf.py         badge.pdf: its shapes in mm, the board at true scale, and the page of a line mask
pitch_bands.py  the bands outside the trim that show a sheet's pitch
sheet_layout.py  where many boards lie on sheets, and how many pages these are
smooth_page.py  lines that bend, as stairs of dots or as outlines
marks.py       what a board shows besides its lines, as one list: markers, words, pictures, QR code; its two writers
preview.py     preview.png, the board as a camera sees it
chart_page.py  the pitch test sheet
camera_page.py  the chart that a camera is calibrated with
"""
