"""print-your-badge, which is also moireid print.

print_cmd.py      the command: its options, read into an order
print_options.py  options about the design and the mount
wear_options.py   options about size and looks
one_badge.py      an order, and the badge of one person made from it
people_cmd.py     the badges of a list of people
"""
