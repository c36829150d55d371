"""Films at the edge and beyond.

suite.py  the cases       output.py  tables and plots
"""
