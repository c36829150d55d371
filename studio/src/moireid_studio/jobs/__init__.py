"""Work that takes time; each job has its own process.

queue.py       the jobs of a studio: accepted, looked up, removed
workers.py     threads that do jobs, and tidy up
cluster.py     films judged by the workers of a Dask scheduler
claims.py      what a job's process gets: the claimed badge, and what the registry knows of it
child.py       the process for each job, and checks of what it says
task.py        a piece of work
work.py        what a film's process does, sealed
issue_work.py  what the process does that makes badges and issues them
orders.py      a visitor's orders, checked as by the command
lists.py       lists of people: the badge of each row, with its pictures
"""
