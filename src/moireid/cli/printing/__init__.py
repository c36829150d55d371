"""Badges made by the command line.

print_cmd.py     print-your-badge, moireid print
wear_options.py  its options about size and looks
wear.py          what they ask for, in the studio too
"""
