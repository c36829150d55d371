"""What a registry offers, by kind.

reading.py   records looked up
outward.py   what it shows to those outside: its standing, checkpoints, bundles
deciding.py  what is decided of a badge after its issue: revoked, suspended, reinstated
"""
