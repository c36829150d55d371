"""The published pipeline, kept as the baseline that every collection is scored against.

published.py  its verdict by correlation of fringes and place
corners.py    corners given by hand, followed
"""
