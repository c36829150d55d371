"""Changes the authority's key: one log entry that both keys sign, and all records signed anew.

The log's entries stay as they are, because checkpoints cover them.  The old key and its file are not needed any more.
"""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy import bindparam, select, update

from moireid.registry import schema
from moireid.registry.engine import chunks
from moireid.registry.keys import RECORD, Signer, new_key
from moireid.registry.ledger import Ledger, Transaction
from moireid.registry.log import rotation_row

Progress = Callable[[int, int | None], None]


def rotate(ledger: Ledger, actor: str, progress: Progress | None) -> int:
    """What `Registry.rotate_key` does."""
    old = ledger.signer()
    # The new key is on the disk before the registry says that it is the authority's.
    new, path = new_key()
    try:
        with ledger.writing(actor) as transaction:
            count = _signed_anew(transaction, new, progress)
            row = rotation_row(old, new, transaction.growing.size, transaction.committed())
            transaction.append([row], new, public_key=new.authority.public_hex)
            transaction.successor = new.authority.public_hex
    except BaseException:
        # A key that the registry did not take is removed; if that is not known, it stays.
        stored = [row.public_key for row in ledger.unchecked().rows(select(schema.authority))]
        if stored != [new.authority.public_hex]:
            path.unlink(missing_ok=True)
        raise
    return count


def _signed_anew(transaction: Transaction, new: Signer, progress: Progress | None) -> int:
    """Sign all records with the new key, each checked by the old one first."""
    statement = update(schema.badges).where(schema.badges.c.id == bindparam("of")).values(signature=bindparam("by"))
    done = 0
    for rows in chunks(schema.pages(transaction.connection, schema.select_records(), schema.badges.c.id)):
        records = [transaction.ledger.record(row) for row in rows]
        signed = [{"of": record.id, "by": new.sign(RECORD, record.signed_text)} for record in records]
        transaction.connection.execute(statement, signed)
        done += len(rows)
        if progress:
            progress(done, None)
    return done
