"""What a forged film shows.

shown.py    the truth, or a forgery of any kind     courses.py  false courses of the fringes
patches.py  parts of a badge that disagree          flat.py     a photograph, and a replay on a screen
"""
