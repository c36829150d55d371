"""Who was issued which badge, in a database that SQLAlchemy can reach: an SQLite file unless told otherwise.

Each record bears the signature of the registry's authority, and everything done stands in a chained, signed log.

url.py         the registry's URL: the default one, reading one, showing one without its password
engine.py      from a URL to connections: SQLite's habits, and the database's errors in our words
keys.py        the authority's key pair, and signatures by kind of thing signed
canonical.py   documents as bytes: one spelling for signing, packed for storing
record.py      the Record, what of it is signed, and the look at its signature on reading
log.py         the log's entries, their chain, and the head
schema.py      the tables, their version, and the look at them on opening
ledger.py      transactions that write table and log together, one writer after the other
claims.py      from a name or an id to the one record it means
claimed.py     what a check needs of a claim; whom identification may find
store.py       the Registry: enroll, find, list, revoke, and the doors to the rest
batch.py       many badges at once
audit.py       everything held against everything; what cannot show is listed there
transfer/      a registry to a JSON file, and back
"""

from moireid.registry.audit import Audit, Finding
from moireid.registry.batch import Batch
from moireid.registry.claimed import Claimed, People, claimed
from moireid.registry.record import Record
from moireid.registry.store import Registry, import_registry, open_registry
from moireid.registry.transfer.merge import Import
from moireid.registry.url import default_url

__all__ = [
    "Audit",
    "Batch",
    "Claimed",
    "Finding",
    "Import",
    "People",
    "Record",
    "Registry",
    "claimed",
    "default_url",
    "import_registry",
    "open_registry",
]
