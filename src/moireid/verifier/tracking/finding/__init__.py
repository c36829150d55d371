"""Where pages may be in a picture: a search that needs no frame before it.

markers.py       pages with four squares
page_groups.py   which squares belong to one page
page_finder.py   the search for pages, by squares or by a frame
coded_frames.py  pages with a thin coded frame
"""
