"""The check that a record is the newest version in the log.

Reading a record compares it only with its newest entry among those that are present.  An attacker who can write to the
database could put back a record as it was before its revocation, and change the revocation's entry, or remove it from
the middle of the log.  No proof of inclusion shows that, as the older entry is in the tree too.  So the entries from
the record's own to the last one are all looked at, and must be those of the signed root.
"""

from __future__ import annotations

from moireid.errors import RegistryError
from moireid.registry.ledger import Ledger
from moireid.registry.record import Fault, Record


def check_newest(ledger: Ledger, record: Record) -> None:
    """Check the log from the record's newest entry to its signed head.

    Raises: RegistryError if an entry on the way was changed or taken out, or is about another version of the record; or
        if witnesses must have seen it, and it is later than they have.  What bars a badge counts unseen.
    Source: the root over all entries is signed; so no signature on the way counts.  100,000 entries take about a
    second.
    """
    with ledger.snapshot() as connection:
        tree = ledger.tree_in(connection)
        newest = tree.newest_entry(record.id, record.digest())
        seen = ledger.witnessed
        if seen is not None and tree.consistency(seen.seq, bytes.fromhex(seen.hash)) is None:
            raise Fault("forked", f"the log's first {seen.seq} entries are not those that witnesses have seen")
    if seen is not None and newest > seen.seq and record.barred() is None:
        raise RegistryError(
            f"the record of badge {record.id} is of log entry {newest}, and witnesses have seen {seen.seq} entries; "
            "get a newer checkpoint from those who run the registry",
            code="not_witnessed",
        )
