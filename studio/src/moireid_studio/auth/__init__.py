"""Who may do what.

guard.py   no requests from other sites
tokens.py  tokens and sessions
"""
