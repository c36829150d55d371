"""Signed verdicts on the command line.

signing.py     the options of `verify --sign`; the signed files, planned first and written last
attest_cmd.py  attest check
"""
