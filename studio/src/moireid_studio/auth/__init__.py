"""Who may do what.

guard.py   the rule of each route, and no requests from other sites
tokens.py  tokens, and the sessions of browsers
"""
