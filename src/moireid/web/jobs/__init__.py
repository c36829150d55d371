"""Work that takes time, each in a process of its own.

queue.py  jobs that wait, work, are over           child.py        the process for each film; task.py its work
work.py   what that process does                   issue_work.py, enroll_work.py  the same for badges and captures
orders.py what is wished, checked as by command    events.py       a job's progress, as it changes
"""
