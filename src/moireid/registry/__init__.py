"""Who was issued which badge, in a database that SQLAlchemy can reach: an SQLite file unless told otherwise.

url.py      the registry's URL: the default one, reading one, showing one without its password
engine.py   from a URL to connections: SQLite's habits, and the database's errors in our words
schema.py   the tables, their version, and the look at them on opening
store.py    the Registry: enroll, find, list
"""

from moireid.registry.store import Record, Registry, open_registry
from moireid.registry.url import default_url

__all__ = ["Record", "Registry", "default_url", "open_registry"]
