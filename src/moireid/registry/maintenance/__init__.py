"""What is done to a registry as a whole.

opening.py    tables made, looked at, and brought to this version      migration.py  the steps from older versions
erasure.py    people and actors erased, and what is left of them       cleaning.py   deleted rows, off the disk too
told.py       the log as it is told
"""
