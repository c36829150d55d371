"""The report for people.

page.py   one page that needs no other file      plots.py  its plots
"""
