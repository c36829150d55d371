"""The engine of collections: many films or clips, each by itself, on this machine or on a Dask cluster.

addresses.py  files by fsspec address: joined, stamped, fetched whole to a folder that is removed after
isolated.py   a process within limits that does one job at a time: jobs in, outcomes or the reason of a loss out
worker.py     what a Dask worker does with one film: fetch it, have its jobs done, hand the outcomes over
engine.py     all tasks on a local cluster, on any Dask deployment by address, or in place where one worker is enough
parts.py      rows in Parquet as they come: parts written whole, readable at any time
"""
