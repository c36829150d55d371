"""The mount to 3D-print.

tray.py  the tray that holds page and lens sheet    holders.py  lanyard, clip and stand    mount.py  its files
snap.py  the holder that a finished badge is pressed into
"""
