"""Who may do what.

roles.py  `require("issuer")`     tokens.py  tokens, stored only as hashes     guard.py  no requests from other sites
"""
