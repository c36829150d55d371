"""Words of any script as placed glyphs, in a PDF as text and in a picture: one shaper for both.

fonts/       the fonts that come with the program: three typefaces, and scripts that these lack
fonts.py     which fonts a typeface is set in, in which order; what no font here has, and what to install
direction.py which letters run from right to left, and where a line turns
shaping.py   words → glyphs with their places, in the order in which they are seen
outlines.py  outlines of glyphs, as curves and as strokes
pdf_text.py  glyphs in a PDF, as text that can be searched and copied
raster.py    glyphs in a picture
"""
