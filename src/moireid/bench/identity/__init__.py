"""Is the whole identity read, and is an original distinguished from a copy?

suite.py     over distance, printing and assembly     clips.py    films for it
matching.py  false matches, by a model of errors      shorter.py  films cut short
output.py    tables and plots
"""
