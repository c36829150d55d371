"""The table of jobs."""

from __future__ import annotations

from sqlalchemy import BigInteger, Column, Float, Index, Integer, MetaData, Table, Text

metadata = MetaData()
#: `lane`: "issue" or "judge"; `turn`: how many jobs of the owner were there before it; `wish`, `about`, `result`,
#: `kept`, `problem`: JSON; `holder`: the process that receives or works; `taken`: how often it was begun, which with
#: the holder tells who may end it; `lease`: until when the holder has it, of one that waits from when on it may be
#: taken; `settled`: how it has ended, before what is left of it was tidied up.  Times: s, of the database's clock.
jobs = Table(
    "jobs",
    metadata,
    Column("id", Text, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("lane", Text, nullable=False),
    Column("owner", Text, nullable=False),
    Column("role", Text, nullable=False),
    Column("state", Text, nullable=False),
    Column("turn", Integer, nullable=False),
    Column("made", Float(53), nullable=False),
    Column("tries", Integer, nullable=False),
    Column("taken", Integer, nullable=False),
    Column("taken_at", Float(53)),
    Column("holder", Text),
    Column("lease", Float(53), nullable=False),
    Column("settled", Text),
    Column("ended", Float(53)),
    Column("video", Text),
    Column("bytes", BigInteger, nullable=False),
    Column("read", Integer, nullable=False),
    Column("expected", Integer),
    Column("wish", Text, nullable=False),
    Column("about", Text, nullable=False),
    Column("result", Text),
    Column("kept", Text),
    Column("problem", Text),
)
Index("jobs_by_state", jobs.c.state, jobs.c.lease)
