"""The pages.

home.py         first page, help, signing in
verify.py       a film and its verdict
registry.py     records, revoking, audit
issue.py        one person, or an event
enroll.py       a capture, measured, then kept
preview_law.py  what static/fringes.js draws
verdicts.py     which verdicts were given
"""
