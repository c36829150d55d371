"""Where the studio keeps its own things: in SQLite files of its folder, all but jobs also on PostgreSQL.

database.py       connections, the database's clock, outages, and the table of jobs
job.py            a job, to a row and back
ledger.py         the steps of a job, and how they are taken up after a crash
stored_pictures.py  pictures in archives
"""
