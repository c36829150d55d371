"""The registry: who was issued which badge, in a database that SQLAlchemy can reach; by default an SQLite file.

The registry's authority signs each record, and every action is recorded in a log under one signed root.

engine.py       the registry's URL, connections, SQLite's settings; database errors as our own errors
keys.py         the authority's key pair, signatures by kind of thing signed, and actors
canonical.py    documents as bytes: one spelling for signing, compressed for storing
record.py       the Record, its signed text, and the check of its signature on reading
merkle.py       the Merkle tree of RFC 6962: roots, and proofs of consistency
log.py          the log's entries, and the head
log_tree.py     the tree over the log: its root, proofs, and entries checked against it
schema.py       the tables and their queries
seen.py         which authority and which head this user saw last
rollback.py     a log compared with what was seen of it: rolled back, forked, or under another key
ledger.py       transactions: those that read compare the head with what was seen; those that write, one after the
                other, write table and log together, and remember the head
look_alikes.py  names that look alike
claimed.py      the badge that a claim means; who holds a badge; whom identification may find
store.py        the Registry: enroll, and calls to the other modules
queries.py      the Registry's methods that only read: from a claim (a name or an id) to the one record that it means;
                list, search, the log's entries
changes.py      the Registry's methods that change a badge after its issue, or erase a person
public_view.py  the Registry's methods for outsiders: standing, checkpoints, bundles
opening.py      makes the tables, and checks them
transfer.py     export: a checked copy in a file; import: checks such a file and merges it into a registry
audit.py        checks the whole log and all records; lists what an audit cannot find
audit_findings.py  what it finds, and its counts
checkpoints/    signed checkpoints that others keep, and signatures of witnesses on them
bundle/         what a verifier needs, in one signed file
"""

from moireid.provenance import BadgeHolder
from moireid.registry.audit_findings import Audit
from moireid.registry.claimed import claimed, claimed_by_file, holder_of, holds
from moireid.registry.engine import default_url
from moireid.registry.record import Record
from moireid.registry.store import Registry, import_registry, open_registry

__all__ = [
    "Audit",
    "BadgeHolder",
    "Record",
    "Registry",
    "claimed",
    "claimed_by_file",
    "default_url",
    "holder_of",
    "holds",
    "import_registry",
    "open_registry",
]
