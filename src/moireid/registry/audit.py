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

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

from sqlalchemy import Connection, func, select

from moireid.errors import RegistryError
from moireid.registry.audit_findings import Audit
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.cosignature import signers
from moireid.registry.checkpoints.note import VerifierKey
from moireid.registry.engine import AnySelect
from moireid.registry.ledger import Ledger
from moireid.registry.log import ERASE, NO_RECORD, REFINED, REPLACED, check_entry
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.record import Fault, record_of
from moireid.registry.rollback import CODES, Watch, check_begins
from moireid.registry.schema import badges, log, pages, select_records

#: Entries and records between two reports of progress.
STEP = 500


def audit(
    ledger: Ledger,
    progress: Callable[[int, int | None], None] | None = None,
    since: Sequence[Checkpoint] = (),
    witnesses: Sequence[VerifierKey] = (),
) -> Audit:
    """What `Registry.audit` does."""
    watch = Watch(ledger.called, ledger.place) if ledger.checked else None
    seen = Audit(ledger.authority.fingerprint)
    if witnesses:
        _audit_witnesses(since, witnesses, seen)
    with ledger.snapshot(checked=False) as connection:
        counts = (select(func.count()).select_from(table).scalar_subquery() for table in (badges, log))
        total = sum(connection.execute(select(*counts)).one())

        def step(done: int) -> None:
            if progress and (done % STEP == 0 or done == total):
                progress(done, total)

        end = _audit_end(ledger, connection, watch, since, seen)
        newest = _audit_log(ledger, connection, seen, step)
        # After a gap, which is reported, no root is that of the head.
        if end is not None and (end.code != "head_hash" or all(one.code != "entry_missing" for one in seen.findings)):
            seen.report(end)
        _audit_records(ledger, connection, newest, seen, step)
    return seen


def _audit_witnesses(since: Sequence[Checkpoint], witnesses: Sequence[VerifierKey], seen: Audit) -> None:
    """Note the newest of the checkpoints that all witnesses signed; a finding if there is none."""
    refusal = "witnesses must have signed a checkpoint, and none is given"
    for one in sorted(since, key=lambda one: -one.head.seq):
        try:
            seen.witnessed = {"size": one.head.seq, "signers": signers(witnesses, one.note, f"of {one.date}")}
            return
        except RegistryError as error:
            refusal = str(error).partition(";")[0]
    seen.report(Fault("not_witnessed", refusal))


def _audit_end(
    ledger: Ledger, connection: Connection, watch: Watch | None, since: Sequence[Checkpoint], seen: Audit
) -> Fault | None:
    """Check the signed head, and compare the log with earlier states; returns why it has no valid head, if so."""
    try:
        tree = ledger.tree_in(connection, anew=True)
    except Fault as fault:
        # Of other tables than moireid's, nothing can be said.
        if fault.code == "tables":
            raise
        return fault
    seen.head = str(tree.head)
    if watch is not None:
        # An entry that was changed is found again, and counted; but then this state is not remembered.
        with _noted(seen), suppress(Fault):
            watch.compare(seen.fingerprint, tree.leaves, tree.head, ledger.trust)
            ledger.check_new(tree, watch)
            standing = watch.standing(seen.fingerprint, tree.leaves, tree.head, ledger.trust)
            ledger.remembered = standing.remembered
    for one in since:
        with _noted(seen, one.head.seq):
            one.check(ledger.authority, f"of {one.date}")
            check_begins(ledger.called, tree.leaves, one.head, f"the checkpoint of {one.date}")
    return None


@contextmanager
def _noted(seen: Audit, subject: object = None) -> Iterator[None]:
    """Turn a refusal for an earlier state into a finding."""
    try:
        yield
    except RegistryError as error:
        if error.details.get("code") not in CODES:
            raise
        seen.report(Fault(str(error.details["code"]), str(error.details["finding"]), subject))


def _audit_log(ledger: Ledger, connection: Connection, seen: Audit, step: Callable[[int], None]) -> dict[str, str]:
    """Check the log from its first entry on; returns the hash of each record's newest version."""
    last, newest, ended = 0, dict[str, str](), set[str]()
    for row in pages(connection, select(log), log.c.seq):
        seen.entries += 1
        try:
            check_entry(row, last, ledger.authority)
        except Fault as fault:
            seen.report(Fault(fault.code, fault.text, row.seq))
        # Go on from this entry's own number, if it has one, so that one fault gives only one finding.
        last = last if row.seq is None else row.seq
        if row.action == ERASE:
            seen.erased += 1
            ended.add(row.subject)
        elif row.subject in ended:
            text = f"log entry {row.seq} is about id {row.subject}, whose holder was erased before: it was issued again"
            seen.report(Fault("erased_again", text, row.subject))
        # The first entry is about the authority.
        newest[row.subject] = NO_RECORD if row.action == "init" else row.record_sha256
        step(seen.entries)
    return newest


def _audit_records(
    ledger: Ledger, connection: Connection, newest: dict[str, str], seen: Audit, step: Callable[[int], None]
) -> None:
    """Check each record against its signature and its newest entry, and that each one in the log is there."""
    changed = select(func.count()).where(log.c.subject == badges.c.id, log.c.action.in_((REPLACED, REFINED)))
    query: AnySelect = select_records().add_columns(changed.scalar_subquery().label("changed"))
    for row in pages(connection, query, badges.c.id):
        seen.records += 1
        step(seen.entries + seen.records)
        seen.revoked += row.revoked_at is not None
        logged = newest.pop(row.id, None)
        try:
            record = record_of(row, ledger.authority)
        except Fault as fault:
            seen.report(Fault(fault.code, fault.text, row.id))
            continue
        if logged != row.newest:
            text = f"the record of id {row.id} is not the version that the log has last, which an index hides"
            seen.report(Fault("record_stale", text, row.id))
        if (row.skeleton, row.folded) != (skeleton(record.name), folded_skeleton(record.name)):
            text = f"what the name of id {row.id} looks like was changed, so look-alikes of it are not found"
            seen.report(Fault("record_skeleton", text, row.id))
        if (kept := len(record.earlier_figures)) < row.changed:
            text = f"of id {row.id} {kept} earlier sets of measured figures are on record, and {row.changed} were"
            seen.report(Fault("figures_missing", text, row.id))
    for subject, digest in newest.items():
        if digest != NO_RECORD:
            text = f"the log has id {subject}, but it has no record"
            seen.report(Fault("record_missing", text, subject))
