"""Where pages may lie in a picture: a search that needs no frame before it.

markers.py       pages with four squares
page_groups.py   which squares belong to one page
coded_frames.py  pages with a thin coded frame
"""
