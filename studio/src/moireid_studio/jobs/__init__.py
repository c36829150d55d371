"""Work that takes time; each job has its own process.

queue.py       the jobs of a studio: taken in, found, removed
workers.py     threads that do them, and tidy up
claims.py      from its wish to what its process gets
cluster.py     films judged by a Dask deployment
child.py       the process for each job
work.py        what a film's process does, sealed
issue_work.py  badges and their packages
orders.py      wishes, checked as by the command
lists.py       lists of people: what each badge wears
"""
