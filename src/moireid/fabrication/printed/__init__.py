"""The mount to 3D-print.

openings.py    the openings of a printed back, with ribs between
tray.py        the tray that holds page and lens sheet: its figures
tray_shape.py  the tray as a solid
holders.py     what carries the tray: lanyard, clip or stand
mount.py       all bodies of a mount, and its STL and 3MF files
"""
