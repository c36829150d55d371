"""Pages, read back from what was written.

raster.py           a page as it is painted
painted.py          the edges of that page against the badge
calibration.py      photographs of a pitch test
strip_photographs.py  the ink strip of a pitch test, printed and photographed by odd cameras
fabricate_suite.py  the fabricate suite
"""
