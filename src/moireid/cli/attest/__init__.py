"""Signed verdicts on the command line.

signing.py     what `verify --sign` asks for, planned first and written last
attest_cmd.py  attest check
"""
