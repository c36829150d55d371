"""The report for people.

page.py   one page in one file                   plots.py  its plots
"""
