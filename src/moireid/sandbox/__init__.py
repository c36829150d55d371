"""Processes that read an untrusted film within limits of memory and time; a crash or a hang harms only the process
itself.

file_access.py  which files a sealed process may read
calls.py        which system calls a sealed process may make
seccomp.py      a filter of system calls, by libseccomp
landlock.py     which files are open, by the kernel's Landlock
seal.py         resource limits, and how a process seals itself; which parts of the seal hold on this system
child.py        the process: `python -m moireid.sandbox.child`; it does some work, or forks a process for each request
line.py         the parent's end of the connection; no call waits longer than the time that its caller gives
process.py      the parent's side: start a process, send messages, receive answers, end it

Convention: messages to the process are pickled, as they come from us.  Its answers are JSON and are never unpickled, as
    it has read untrusted files.
"""
