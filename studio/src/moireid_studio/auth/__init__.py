"""Who may do what.

roles.py   `require("issuer")`      guard.py         no requests from other sites
tokens.py  tokens and sessions      token_tables.py  where only their hashes are kept
"""
