"""print-your-badge, which is also moireid print.

print_cmd.py      the command: its options, read into an order; the badge of one person made from it
print_options.py  the options about size, looks, design and mount
people_cmd.py     the badges of a list of people
materials_cmd.py  moireid materials: what to buy for badges, and how to cut it
"""
