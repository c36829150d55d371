"""Who was issued which badge, in a database that SQLAlchemy can reach; by default an SQLite file.

The registry's authority signs each record, and every action is recorded in a chained, signed log.

engine.py       from a URL to connections; SQLite's settings; database errors as our own errors
keys.py         the authority's key pair, and signatures by kind of thing signed
canonical.py    documents as bytes: one spelling for signing, packed for storing
record.py       the Record, its signed text, and the check of its signature on reading
log.py          the log's entries, their chain, and the head
schema.py       the tables, and what is asked of them
ledger.py       transactions that write table and log together, one writer after the other
claims.py       from a name or an id to the one record it means
look_alikes.py  names that the eye takes for one another
claimed.py      the badge that a claim means; who holds a badge; whom identification may find
store.py        the Registry: enroll, revoke, and calls to the rest
face/           the rest of what a Registry offers: look-ups, standing, checkpoints, bundles
batch.py        many badges at once
audit.py        checks the whole log and all records; lists what an audit cannot find
signing/        the private key in a process of its own
checkpoints/    signed checkpoints that others keep, and what this user saw last
bundle/         what a verifier needs, in one signed file
transfer/       a registry to a JSON file, and back
maintenance/    opening, older versions, the log as it is told, people erased
"""

from moireid.provenance import BadgeHolder, ClaimedBadge
from moireid.registry.audit import Audit, Finding
from moireid.registry.batch import Batch
from moireid.registry.claimed import People, claimed, claimed_by_file, holder_of
from moireid.registry.engine import default_url
from moireid.registry.look_alikes import LookAlikeWarning
from moireid.registry.record import Record
from moireid.registry.store import Registry, import_registry, open_registry
from moireid.registry.transfer.merge import Import

__all__ = [
    "Audit",
    "BadgeHolder",
    "Batch",
    "ClaimedBadge",
    "Finding",
    "Import",
    "LookAlikeWarning",
    "People",
    "Record",
    "Registry",
    "claimed",
    "claimed_by_file",
    "default_url",
    "holder_of",
    "import_registry",
    "open_registry",
]
