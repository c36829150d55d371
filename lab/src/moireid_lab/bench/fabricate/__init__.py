"""Pages and mounts, read back from what was written.

raster.py           a page as it is painted
painted.py          the edges of that page against the badge
calibration.py      photographs of a pitch test
strip_photographs.py  the ink strip of a pitch test, printed and photographed by odd cameras
fabricate_suite.py  the fabricate suite, with its table and plots
page_extremes.py    pages at the edge of what can be made
mount_extremes.py   mounts at the edge of what can be made
"""
