"""Badges made by the command line.

print_cmd.py       print-your-badge, moireid print: its options, read into an order
design_options.py  options about what is read, and of what the badge is made
wear_options.py    options about size and looks
mount_options.py   options about the mount
gathering.py       options of one subject as one argument
wear.py            what size and looks ask for, in the studio too
order.py           what is to be printed
one_badge.py       the badge of one person, from an order to its files
people.py          the badges of a list
"""
