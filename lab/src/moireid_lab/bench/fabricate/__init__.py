"""Pages and mounts, read back from what was written.

raster.py           a page as it is painted
painted.py          its edges against the badge
calibration.py      photographs of a pitch test
fabricate_suite.py  table and plots of the fabricate suite
page_extremes.py, mount_extremes.py  what is asked at the edge of what can be made
"""
