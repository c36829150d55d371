"""The live check.

routes.py  its page and its socket         worker.py  the process behind one session
"""
