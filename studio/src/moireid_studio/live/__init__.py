"""The live check, *Check a call*, and one-time links.

routes.py      pages and sockets of the two checks
sockets.py     one session over a socket
worker.py      the process of one session
link_pages.py  one-time links, for the person who asks
link_check.py  one-time links, for the person who is asked
"""
