"""A registry to a JSON file and back, and to another key.

export.py  write records, log and public key to a JSON file; read a large JSON file in little memory
load.py    read an export into an empty registry; notes on names that look alike
merge.py   import: check an export and merge it into a registry
rotate.py  change the authority's key
"""
