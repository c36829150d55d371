"""The live check, and *Check a call*.

routes.py  their pages and sockets     sockets.py  one session over a socket
worker.py  the process behind one session
link_pages.py  one-time links for who asks     link_check.py  and for who is asked
"""
