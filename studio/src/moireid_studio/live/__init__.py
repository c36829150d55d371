"""The live check, *Check a call*, and one-time links.

routes.py       pages and sockets of the two checks
sockets.py      one session over a socket
worker.py       the process of one session
link_routes.py  one-time links: their pages, and the check
"""
