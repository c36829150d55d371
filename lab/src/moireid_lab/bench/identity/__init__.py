"""Is the whole identity read, and do the figures of enrolment identify a rebuilt copy?

suite.py     over distance, printing and assembly     clips.py    films for it
matching.py  false matches, by a model of errors      shorter.py  films cut short
output.py    tables and plots
"""
