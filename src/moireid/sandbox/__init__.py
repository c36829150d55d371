"""Processes that judge a stranger's film, within limits of memory and time: they may crash, hang or grow by themselves.

limits.py   what such a process may take, and how it is held to that
child.py    the process: `python -m moireid.sandbox.child`, which does some work, or forks a process for each time
process.py  the process as the one who started it sees it: begun, sent messages, heard, ended

Convention: messages to the process are pickled, as they come from us; what it says is JSON, and is never unpickled, as
it has read what a stranger made.
"""
