"""The mount to 3D-print.

openings.py the openings of their backs, with ribs between
tray.py     the tray that holds page and lens sheet
holders.py  what carries the tray: lanyard, clip or stand
snap.py     the holder that a finished badge is pressed into
mount.py    all bodies of a mount, and its STL and 3MF files
"""
