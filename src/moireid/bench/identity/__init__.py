"""Does the whole identity come back; original or copy?

suite.py     over distance, printing and assembly     clips.py    films for it
matching.py  false matches, by a model of errors      shorter.py  films cut short
output.py    tables and plots
"""
