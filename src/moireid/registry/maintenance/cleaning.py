"""What was deleted, off the disk too: a database keeps old rows in pages that it does not use.

SQLite overwrites what it deletes (`secure_delete`, set in engine.py), and VACUUM writes the file anew without what
older versions left in it.  PostgreSQL writes the tables anew, and its statistics, which hold values of columns.
What neither reaches: copies and backups, PostgreSQL's write-ahead log until it is recycled, and blocks that a disk
keeps by itself.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing

from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

#: The tables that hold names.
NAMING = ("badges", "actors")


def clean(engine: Engine) -> bool:
    """Write anew what held names; returns whether that was done: not where others hold the database, or it is full."""
    try:
        if engine.dialect.name == "sqlite":
            # Not by SQLAlchemy's connection: it begins a transaction, in which SQLite refuses this.
            with closing(engine.raw_connection()) as raw:
                assert raw.driver_connection is not None
                raw.driver_connection.execute("VACUUM")
            return True
        if engine.dialect.name == "postgresql":
            with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
                for table in NAMING:
                    connection.exec_driver_sql(f"VACUUM (FULL, ANALYZE) {table}")
            return True
    except (sqlite3.Error, SQLAlchemyError):
        return False
    return False
