"""Pages and mounts, read back from what was written.

suite.py          pages by form and resolution, mounts by the angle of their facets
raster.py         a page as it is painted                painted.py        its edges against the badge
calibration.py    photographs of a pitch test
page_extremes.py, mount_extremes.py  what is asked at the edge of what can be made
output.py         tables and plots
"""
