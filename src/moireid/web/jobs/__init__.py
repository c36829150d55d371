"""Work that takes time; each job has its own process.

queue.py  jobs that wait, run, and are finished    child.py        the process for each film; task.py its work
work.py   what that process does                   issue_work.py, enroll_work.py  the same for badges and captures
orders.py wishes, checked as by the command        events.py       a job's progress, as it changes
"""
