"""Is the whole identity read, and do the figures of enrolment identify a rebuilt copy?

clips.py           films for it
matching.py        false matches, by a model of errors
identity_suite.py  the identity suite
"""
