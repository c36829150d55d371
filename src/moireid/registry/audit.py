"""The audit: the whole log and all records, checked against each other and against the authority's key.

1. The log: the entries are numbered without a gap, the hash of each is that of its content, and it bears the signature
   of the authority.  The tree over them is computed anew.
2. The head is signed and is the root of that tree; the log still begins as the checkpoints that others keep say; if
   witnesses must have signed one of those, enough did.
3. Each record bears the signature, and is the newest version in the log; none is without an entry.
4. Each record that the log enters is there, unless a later entry says that the person was erased; after that, no
   entry is about them.
5. Each set of measured figures that a log entry put in the place of another is followed by that other on record.
6. The log goes on from the head that this user saw last, under the same key.

What it cannot find by itself:
- the whole registry, head included, put back to a state that is earlier, and later than all that this user saw: it was
  sound then.  A checkpoint that another person keeps shows it.
- a whole registry made anew under another key, of which this user saw nothing before.  The first entry names the key,
  so a checkpoint, or the fingerprint, shows it.
- actions by a person who has the private key: they can enroll and revoke in the authority's name.  If
  no one keeps a checkpoint, they can even rewrite the log from its first entry on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, exists, func, select

from moireid.errors import RegistryError
from moireid.registry.audit_findings import Audit, Tally
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.cosignature import signers
from moireid.registry.checkpoints.note import VerifierKey
from moireid.registry.engine import AnyRow, AnySelect
from moireid.registry.ledger import Ledger
from moireid.registry.log import (
    ERASE,
    REFINED,
    REPLACED,
    Head,
    check_entry,
    check_head,
    leaf_of,
)
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.merkle import Tree
from moireid.registry.opening import check_tables
from moireid.registry.record import Fault, record_of
from moireid.registry.rollback import CODES
from moireid.registry.schema import authority, badges, log, pages, select_records


def audit(
    ledger: Ledger,
    progress: Callable[[int, int | None], None] | None = None,
    since: Sequence[Checkpoint] = (),
    witnesses: Sequence[VerifierKey] = (),
) -> Audit:
    """What `Registry.audit` does."""
    with ledger.unchecked().snapshot() as connection:
        check_tables(connection, ledger.shown)
    refused, ledger = _refused(ledger), ledger.unchecked()
    kept = [one for one in since if one.fingerprint == ledger.authority.fingerprint]
    for one in kept:
        one.check(ledger.authority, f"of {one.date}")
    counts = (select(func.count()).select_from(table).scalar_subquery() for table in (badges, log))
    tally = Tally(progress, sum(ledger.rows(select(*counts))[0]))
    if refused is not None:
        tally.report(str(refused["code"]), str(refused["finding"]))
    witnessed = _audit_witnesses(since, witnesses, tally) if witnesses else None
    for one in since:
        if one not in kept:
            text = (
                f"the registry is signed by authority {ledger.authority.fingerprint}, and the checkpoint of {one.date} "
                f"by {one.fingerprint}: its key was replaced"
            )
            tally.report("key_replaced", text)
    roots = dict.fromkeys([one.size for one in kept], "")
    with ledger.snapshot() as connection:
        head = _audit_log(ledger, connection, roots, tally)
        _audit_kept(kept, roots, head, tally)
        _audit_records(ledger, connection, tally)
    return Audit(
        fingerprint=ledger.authority.fingerprint,
        head=None if head is None else str(head),
        findings=tuple(tally.findings),
        actors=dict(tally.actors),
        witnessed=witnessed,
        **tally.counts,
    )


def _refused(ledger: Ledger) -> dict[str, object] | None:
    """Why readers refuse the registry for what was seen of it before: code and finding; None if they do not."""
    try:
        if ledger.checked:
            ledger.standing()
    except RegistryError as error:
        if error.details.get("code") in CODES:
            return error.details
        # Any other fault that has a code is found again on the way, and counted.
        if "code" not in error.details:
            raise
    return None


def _audit_witnesses(
    since: Sequence[Checkpoint], witnesses: Sequence[VerifierKey], tally: Tally
) -> dict[str, Any] | None:
    """The newest of the checkpoints that all witnesses signed; a finding if there is none."""
    refusal = "witnesses must have signed a checkpoint, and none is given"
    for one in sorted(since, key=lambda one: -one.size):
        try:
            times = signers(witnesses, one.note, f"of {one.date}")
        except RegistryError as error:
            refusal = str(error).partition(";")[0]
        else:
            return {"size": one.size, "signers": {name: f"{at:%Y-%m-%dT%H:%M:%SZ}" for name, at in times.items()}}
    tally.report("not_witnessed", refusal)
    return None


def _audit_kept(kept: Sequence[Checkpoint], roots: Mapping[int, str], head: Head | None, tally: Tally) -> None:
    """Compare the log with the checkpoints that were kept of it elsewhere; roots: over so many entries."""
    size = tally.counts["entries"]
    for one in kept:
        noted = f"the log ends at entry {size}, and the checkpoint of {one.date} names {one.size} entries"
        if one.size <= size and roots[one.size] != one.root.hex():
            text = (
                f"the log's first {one.size} entries are not those of the checkpoint of {one.date}: it was forked, and "
                "something was written in the place of what had been signed"
            )
            tally.report("forked", text, one.size)
        elif one.size > size and head is None:
            tally.report("log_cut", f"{noted}: its end was cut off", one.size)
        elif one.size > size:
            tally.report(
                "rolled_back", f"{noted}: the registry was rolled back, an earlier state was put back", one.size
            )


def _audit_log(ledger: Ledger, connection: Connection, roots: dict[int, str], tally: Tally) -> Head | None:
    """Check the log from its first entry on.

    Parameters: roots: by the numbers of entries over which they are asked for; they are put in.
    Returns: the head, or None if the head is not valid.
    """
    last, tree, later = 0, Tree(), log.alias("later")
    gone = select(later.c.seq).where(later.c.subject == log.c.subject, later.c.action == ERASE, later.c.seq > log.c.seq)
    query = select(log, badges.c.id.label("holder"), exists(gone).label("erased"))
    query = query.outerjoin(badges, badges.c.id == log.c.subject)
    for row in tally.counted("entries", pages(connection, query, log.c.seq)):
        tree.add(leaf_of(row.hash))
        if tree.size in roots:
            roots[tree.size] = tree.root().hex()
        try:
            check_entry(row, last, ledger.authority)
        except Fault as fault:
            tally.report(fault.code, fault.text, row.seq)
        # Go on from this entry's own number, so that one fault gives only one finding.
        last = row.seq
        _note_actor(row, tally)
        tally.newest[row.subject] = row.record_sha256
        if row.action in ("enroll", "import") and row.holder is None and not row.erased:
            text = f"log entry {row.seq} enters id {row.subject}, but it has no record"
            tally.report("record_missing", text, row.subject)
    try:
        return _check_end(ledger, connection, last, tree)
    except Fault as fault:
        tally.report(fault.code, fault.text)
        return None


def _check_end(ledger: Ledger, connection: Connection, last: int, tree: Tree) -> Head:
    """The signed head.  Raises: Fault if it is not valid, or not that of the entries that were looked at.

    Parameters: last: the number of the last of these; tree: over them.
    """
    top = connection.execute(select(authority)).first()
    if top is None or top.public_key != ledger.authority.public_hex:
        raise Fault("public_key", "the registry has come under another authority since it was opened")
    head = check_head(top, last or None, ledger.authority)
    # After a gap, which is reported, no root is that of the head.
    if last == tree.size and tree.root().hex() != head.hash:
        raise Fault("head_hash", "the tree over the log's entries is not the one that the signed head names")
    return head


def _note_actor(row: AnyRow, tally: Tally) -> None:
    """Count an entry for its actor, and note the person whom it erased, whom no later entry may be about."""
    tally.counts["erased"] += row.action == ERASE
    if row.action == ERASE:
        tally.ended.add(row.subject)
    elif row.subject in tally.ended:
        text = f"log entry {row.seq} is about id {row.subject}, whose holder was erased before: it was issued again"
        tally.report("erased_again", text, row.subject)
    tally.actors[row.actor] += 1


def _audit_records(ledger: Ledger, connection: Connection, tally: Tally) -> None:
    """Check each record against its signature and its newest entry."""
    changed = select(func.count()).where(log.c.subject == badges.c.id, log.c.action.in_((REPLACED, REFINED)))
    query: AnySelect = select_records().add_columns(changed.scalar_subquery().label("changed"))
    for row in tally.counted("records", pages(connection, query, badges.c.id)):
        tally.counts["revoked"] += row.revoked_at is not None
        try:
            record = record_of(row, ledger.authority)
        except Fault as fault:
            tally.report(fault.code, fault.text, row.id)
            continue
        if tally.newest.get(row.id) != row.newest:
            text = f"the record of id {row.id} is not the version that the log has last, which an index hides"
            tally.report("record_stale", text, row.id)
        if (row.skeleton, row.folded) != (skeleton(record.name), folded_skeleton(record.name)):
            text = f"what the name of id {row.id} looks like was changed, so look-alikes of it are not found"
            tally.report("record_skeleton", text, row.id)
        if (kept := len(record.earlier_figures)) < row.changed:
            text = f"of id {row.id} {kept} earlier sets of measured figures are on record, and {row.changed} were"
            tally.report("figures_missing", text, row.id)
