"""Who may do what.

roles.py  `require("issuer")`     tokens.py  tokens, of which only a hash is kept     guard.py  nothing from other sites
"""
