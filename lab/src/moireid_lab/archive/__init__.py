"""Many films, each by itself, by threads on this machine or on Dask.

engine.py     all tasks of a run
worker.py     one task on a worker
isolated.py   a process for each job, with limits
"""
