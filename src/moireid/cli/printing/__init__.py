"""Badges made by the command line.

print_cmd.py     print-your-badge, moireid print: its options, read into an order
wear_options.py  options about size and looks
wear.py          what size and looks ask for, in the studio too
one_badge.py     the badge of one person, from an order to its files
people.py        the badges of a list
"""
