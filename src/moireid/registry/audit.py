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

from sqlalchemy import Connection, exists, func, select

from moireid.errors import RegistryError
from moireid.registry.audit_findings import Audit
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.cosignature import signers
from moireid.registry.checkpoints.note import VerifierKey
from moireid.registry.engine import AnySelect
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

#: Entries and records between two reports of progress.
STEP = 500


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
    seen = Audit(ledger.authority.fingerprint)
    kept = [one for one in since if one.fingerprint == seen.fingerprint]
    for one in kept:
        one.check(ledger.authority, f"of {one.date}")
    if refused is not None:
        seen.report(Fault(str(refused["code"]), str(refused["finding"])))
    if witnesses:
        _audit_witnesses(since, witnesses, seen)
    for one in since:
        if one not in kept:
            text = (
                f"the registry is signed by authority {seen.fingerprint}, and the checkpoint of {one.date} by "
                f"{one.fingerprint}: its key was replaced"
            )
            seen.report(Fault("key_replaced", text))
    roots = dict.fromkeys([one.head.seq for one in kept], "")
    with ledger.snapshot() as connection:
        counts = (select(func.count()).select_from(table).scalar_subquery() for table in (badges, log))
        total = sum(connection.execute(select(*counts)).one())

        def step(done: int) -> None:
            if progress and (done % STEP == 0 or done == total):
                progress(done, total)

        newest = _audit_log(ledger, connection, roots, seen, step)
        _audit_kept(kept, roots, seen)
        _audit_records(ledger, connection, newest, seen, step)
    return seen


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


def _audit_witnesses(since: Sequence[Checkpoint], witnesses: Sequence[VerifierKey], seen: Audit) -> None:
    """Note the newest of the checkpoints that all witnesses signed; a finding if there is none."""
    refusal = "witnesses must have signed a checkpoint, and none is given"
    for one in sorted(since, key=lambda one: -one.head.seq):
        try:
            times = signers(witnesses, one.note, f"of {one.date}")
        except RegistryError as error:
            refusal = str(error).partition(";")[0]
        else:
            shown = {name: f"{at:%Y-%m-%dT%H:%M:%SZ}" for name, at in times.items()}
            seen.witnessed = {"size": one.head.seq, "signers": shown}
            return
    seen.report(Fault("not_witnessed", refusal))


def _audit_kept(kept: Sequence[Checkpoint], roots: Mapping[int, str], seen: Audit) -> None:
    """Compare the log with the checkpoints that were kept of it elsewhere; roots: over so many entries."""
    for one in kept:
        size = one.head.seq
        if size > seen.entries:
            text = (
                f"the log ends at entry {seen.entries}, and the checkpoint of {one.date} names {size} entries: the "
                "registry was rolled back, an earlier state was put back"
            )
            seen.report(Fault("rolled_back", text, size))
        elif roots[size] != one.head.hash:
            text = (
                f"the log's first {size} entries are not those of the checkpoint of {one.date}: it was forked, and "
                "something was written in the place of what had been signed"
            )
            seen.report(Fault("forked", text, size))


def _audit_log(
    ledger: Ledger, connection: Connection, roots: dict[int, str], seen: Audit, step: Callable[[int], None]
) -> dict[str, str]:
    """Check the log from its first entry on.

    Parameters: roots: by the numbers of entries over which they are asked for; they are put in.
    Returns: the hash of each record's newest version.
    """
    last, tree, later = 0, Tree(), log.alias("later")
    newest, ended = dict[str, str](), set[str]()
    gone = select(later.c.seq).where(later.c.subject == log.c.subject, later.c.action == ERASE, later.c.seq > log.c.seq)
    query = select(log, badges.c.id.label("holder"), exists(gone).label("erased"))
    query = query.outerjoin(badges, badges.c.id == log.c.subject)
    for row in pages(connection, query, log.c.seq):
        seen.entries += 1
        tree.add(leaf_of(row.hash))
        if tree.size in roots:
            roots[tree.size] = tree.root().hex()
        try:
            check_entry(row, last, ledger.authority)
        except Fault as fault:
            seen.report(Fault(fault.code, fault.text, row.seq))
        # Go on from this entry's own number, so that one fault gives only one finding.
        last = row.seq
        if row.action == ERASE:
            seen.erased += 1
            ended.add(row.subject)
        elif row.subject in ended:
            text = f"log entry {row.seq} is about id {row.subject}, whose holder was erased before: it was issued again"
            seen.report(Fault("erased_again", text, row.subject))
        newest[row.subject] = row.record_sha256
        if row.action in ("enroll", "import") and row.holder is None and not row.erased:
            text = f"log entry {row.seq} enters id {row.subject}, but it has no record"
            seen.report(Fault("record_missing", text, row.subject))
        step(seen.entries)
    try:
        seen.head = str(_check_end(ledger, connection, last, tree))
    except Fault as fault:
        seen.report(fault)
    return newest


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


def _audit_records(
    ledger: Ledger, connection: Connection, newest: Mapping[str, str], seen: Audit, step: Callable[[int], None]
) -> None:
    """Check each record against its signature and its newest entry."""
    changed = select(func.count()).where(log.c.subject == badges.c.id, log.c.action.in_((REPLACED, REFINED)))
    query: AnySelect = select_records().add_columns(changed.scalar_subquery().label("changed"))
    for row in pages(connection, query, badges.c.id):
        seen.records += 1
        step(seen.entries + seen.records)
        seen.revoked += row.revoked_at is not None
        try:
            record = record_of(row, ledger.authority)
        except Fault as fault:
            seen.report(Fault(fault.code, fault.text, row.id))
            continue
        if newest.get(row.id) != row.newest:
            text = f"the record of id {row.id} is not the version that the log has last, which an index hides"
            seen.report(Fault("record_stale", text, row.id))
        if (row.skeleton, row.folded) != (skeleton(record.name), folded_skeleton(record.name)):
            text = f"what the name of id {row.id} looks like was changed, so look-alikes of it are not found"
            seen.report(Fault("record_skeleton", text, row.id))
        if (kept := len(record.earlier_figures)) < row.changed:
            text = f"of id {row.id} {kept} earlier sets of measured figures are on record, and {row.changed} were"
            seen.report(Fault("figures_missing", text, row.id))
