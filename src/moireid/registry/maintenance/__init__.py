"""What is done to a registry as a whole.

opening.py  tables made, looked at, and brought to this version
erasure.py  people and actors erased, and what is left of them
told.py     the log as it is told
"""
