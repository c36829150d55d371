"""Work on a registry as a whole: opening, migration, erasure, and the list of its log entries.

opening.py      make the tables, check them, and migrate those of an older version
erasure.py      erase people and actors, and clean the database of their data
log_entries.py  the log's entries, for display only
"""
