"""From an order to a badge's files: the one service that the commands and the studio call.

wear.py  the requested size and looks of a badge, and the mount that suits them
plan.py  `plan_badge`: designs once, plans the parts once, checks everything; `write`: its files and its entry
"""
