"""Where the studio keeps its own things: in SQLite files of its folder, or on a server that several studios share.

database.py       connections, the database's clock, outages, and the table of jobs
job.py            a job, to a row and back
ledger.py         the steps of a job, and which process may make them
build_store.py    first badges that are built here, each in a folder
storage.py        films and what is made of them, by fsspec; pictures in archives
verdict_store.py  which verdicts were given, and to whom
"""
