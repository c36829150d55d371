"""The engine of collections: many films or clips, each processed by itself, on this machine or on a Dask cluster.

addresses.py  files by fsspec address: joined, stamped, fetched to a temporary folder
isolated.py   a process within limits that does one job at a time, sealed where it reads a film: the result, or why none
worker.py     the work of a Dask worker on one film: fetch it, have its jobs done, return the results
engine.py     all tasks on a local cluster, on a Dask deployment by address, or in this process for one worker
parts.py      rows in Parquet, written as they come and readable at any time
"""
