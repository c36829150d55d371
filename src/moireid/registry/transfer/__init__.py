"""A registry to a JSON file, and back.

export.py  records, log and key, written
load.py    read and checked
merge.py   joined with what is there
rotate.py  to another key of its authority
"""
