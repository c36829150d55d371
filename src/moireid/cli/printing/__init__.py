"""print-your-badge, which is also moireid print.

print_cmd.py     the command: its options, read into an order
options.py       options about the design and the mount
wear_options.py  options about size and looks
wear.py          size and looks as a request to the designer; the studio uses it too
one_badge.py     an order, and the badge of one person made from it
people.py        the badges of a list of people
"""
