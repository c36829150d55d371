"""Where the studio keeps its own things: in SQLite files of its folder, or on a server that several studios share.

database.py  connections, the database's clock, and outages
job.py       a job, to a row and back
ledger.py    what may become of a job, and of whom
storage.py   films and what is made of them, by fsspec
verdicts.py  which verdicts were given, and to whom
"""
