"""Where the page is in each frame, and the brightness along its rows.

finding/                pages found in a picture
patches.py              what is printed to find a page by
print_template.py       the patches as a picture shows them
registration.py         the page aligned to its print
borders.py              the gratings' borders, where only two markers are seen
patch_search.py         the patches sought around an expected place
smeared_frames.py       frames that motion smeared
brightness_profiles.py  brightness along each row
edge_spread.py          how sharp the page's edges are
track.py                what a film shows of one badge
badge_tracker.py        one badge over the frames
even_sample.py          frames kept for the code's cells
scene_tracker.py        all badges in view; it owns the tools
search_work.py          what looking costs, and what it may cost
"""
