"""Work that takes time; each job has its own process.

queue.py  jobs that wait, run, and are finished    child.py   the process for each job; task.py its work
work.py   what a film's process does, sealed       making.py  what a process does that makes badges
asking.py what a film's process may ask            issue_work.py, enroll_work.py  badges and captures
orders.py wishes, checked as by the command        events.py  a job's progress, as it changes
heard.py  what a process says, checked
"""
