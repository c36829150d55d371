"""Processes that read an untrusted film within limits of memory and time; a crash or a hang harms only the process
itself.

reach.py    which files a sealed process may open, and what it may know of the environment
calls.py    the filter of calls to the system
seal.py     a process that seals itself; what holds of that on this system
child.py    the process: `python -m moireid.sandbox.child`; it does some work, or forks a process for each request
line.py     the parent's end of the connection, which never waits longer than it is told
process.py  the parent's side: start a process, send messages, receive answers, end it
Convention: messages to the process are pickled, as they come from us.  Its answers are JSON and are never unpickled, as
    it has read untrusted files.
"""
