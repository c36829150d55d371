"""The ledger: a database with its authority, and the transactions that write to both tables and log.

Every write goes through `Ledger.writing`: it locks the head, checks it against the log, and gives a `Transaction`.
That signs each record, adds an entry to the log and its tree, and moves the head, all of it or nothing.
"""

from __future__ import annotations

import secrets
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from sqlalchemy import Connection, Engine, func, insert, select, update
from sqlalchemy.engine import URL

from moireid.errors import RegistryError
from moireid.provenance import Standing
from moireid.registry import schema
from moireid.registry.engine import (
    AnyRow,
    AnySelect,
    connect,
    show_url,
    snapshot,
    translated,
    writing,
)
from moireid.registry.keys import Authority, Signer, key_of
from moireid.registry.log import (
    ERASE,
    NO_RECORD,
    Head,
    check_head,
    head_row,
    leaf_of,
    next_rows,
)
from moireid.registry.log_tree import LogTree
from moireid.registry.opening import Make, prepare
from moireid.registry.record import Fault, Record, record_of, tampered
from moireid.registry.rollback import Watch
from moireid.registry.seen import remember


def open_ledger(url: URL, make: Make | None, *, checked: bool = True) -> Ledger:
    """The ledger at a URL that `read_url` has read.

    Parameters: make: fills an empty database, None if it must be filled; checked: whether it is compared with what was
        seen before, and its state remembered.
    """
    engine = connect(url, create=make is not None)
    try:
        with translated(url):
            public_key, made = prepare(engine, show_url(url), make)
        ledger = Ledger(engine, url, public_key, made=made, checked=checked)
        if made and checked:
            # Whatever was seen at this place before: it was made here.
            with ledger.reported(), snapshot(engine) as connection:
                ledger._keep(ledger.tree_in(connection).head)
        return ledger
    except RegistryError:
        engine.dispose()
        raise


#: Of a record: without its salt no one can check a guess of what the log's hash covers.
SALT_BYTES = 16


class Ledger:
    """A database, and the authority whose signatures count in it."""

    def __init__(self, engine: Engine, url: URL, public_key: str | None, *, made: bool, checked: bool) -> None:
        """Raises: RegistryError if `public_key` is no key, 64 hex digits."""
        self.engine = engine
        self.url = url
        self.shown = show_url(url)
        #: Names the registry in messages.
        self.called = f"registry {self.shown}"
        #: Identifies the registry among all that this user opens; the password is not part of it.
        self.place = url.set(password=None).render_as_string()
        #: The fingerprint of the one authority that counts; None for the one that was seen at this place first.
        self.trust: str | None = None
        #: Whether it was made just now, is compared with what was seen before, and could be remembered.
        self.made, self.checked, self.remembered = made, checked, True
        #: The head that witnesses have seen, if a reader asks for that (`Registry.require_witnesses`); else None.
        self.witnessed: Head | None = None
        #: The log as an earlier transaction read it.
        self._tree: LogTree | None = None
        self._standing: Standing | None = None
        self._signer: Signer | None = None
        try:
            #: The authority whose signatures count.
            self.authority = Authority(public_key or "")
        except (TypeError, ValueError) as error:
            raise tampered(self.shown, Fault("public_key", "its public key is none")) from error

    def signer(self) -> Signer:
        """The private key, read once.  Raises: RegistryError if it is not on this machine."""
        if self._signer is None:
            try:
                self._signer = key_of(self.authority)
            except RegistryError as error:
                details = {"fingerprint": self.authority.fingerprint} | error.details
                raise RegistryError(f"registry {self.shown} can only be read here: {error}", **details) from error
        return self._signer

    @contextmanager
    def reported(self) -> Iterator[None]:
        """Turn a fault, and what the database raises, into a RegistryError that names the registry."""
        try:
            with translated(self.url):
                yield
        except Fault as fault:
            raise tampered(self.shown, fault) from fault

    def standing(self) -> Standing:
        """Compare it with what was seen of it before.  Raises: RegistryError as `Watch.compare`."""
        with self.snapshot():
            assert self._standing is not None
            return self._standing

    def _keep(self, head: Head) -> None:
        self.remembered = remember(self.place, self.authority.fingerprint, head)

    def rows(self, query: AnySelect) -> list[AnyRow]:
        """All rows of a query, in a transaction of its own."""
        with self.snapshot() as connection:
            return list(connection.execute(query))

    def records(self, query: AnySelect) -> list[Record]:
        """The records of a query made by `select_records`.  Raises: RegistryError if one is not as it was signed."""
        with self.snapshot() as connection:
            return [record_of(row, self.authority) for row in connection.execute(query)]

    def count(self) -> int:
        """The number of records."""
        return int(self.rows(select(func.count()).select_from(schema.badges))[0][0])

    def tree_in(self, connection: Connection, *, lock: bool = False, anew: bool = False) -> LogTree:
        """The tree up to the log's head, within a transaction.

        Parameters: lock: other writers wait until it ends; anew: read all entries, also those that were read before.
        Raises: Fault if it has come under another key, the head's signature is wrong, or it is not the end of the log.
        """
        query = select(schema.authority)
        row = connection.execute(query.with_for_update() if lock else query).first()
        if row is None or row.public_key != self.authority.public_hex:
            raise Fault("public_key", "it has come under another authority since it was opened")
        last = connection.scalar(select(func.max(schema.log.c.seq)))
        if not isinstance(last, int | None) or not isinstance(row.head_seq, int):
            # The tables were exchanged; text is the last, so all others are numbers.
            raise Fault("tables", "the numbers of the log's entries are none")
        head = check_head(row, last, self.authority)
        self._tree = tree = LogTree(connection, head, None if anew else self._tree)
        return tree

    def check_new(self, tree: LogTree, watch: Watch) -> None:
        """Check the content of all entries that were not seen before: the tree covers their hashes alone, and lists and
        searches take from the content which version of a record is the newest.

        Raises: Fault if one was changed.
        """
        seen = watch.last(self.authority.fingerprint)
        if seen is not None and seen.seq < tree.head.seq:
            for _ in tree.entries(seen.seq + 1):
                pass

    @contextmanager
    def snapshot(self, *, checked: bool = True) -> Iterator[Connection]:
        """A connection that sees one state of the registry, whatever is written meanwhile.

        Parameters: checked: whether it is compared with what was seen before; if not, the caller reports what is wrong.
        Raises: RegistryError as `Watch.compare`: whatever is shown, judged, exported or counted is read here.
        """
        watch = Watch(self.called, self.place) if self.checked and checked else None
        with self.reported(), snapshot(self.engine) as connection:
            if watch is not None:
                tree = self.tree_in(connection)
                self.check_new(tree, watch)
                self._standing = watch.standing(self.authority.fingerprint, tree.leaves, tree.head, self.trust)
                self.remembered = self._standing.remembered
            yield connection

    @contextmanager
    def writing(self, actor: str, *, older: bool = False) -> Iterator[Transaction]:
        """A transaction, alone among those that write; committed at the end, rolled back if an exception leaves it.

        Its head is remembered as soon as it is committed, so that no earlier one passes from then on.
        Parameters: actor: who writes, as the log is to name them; older: the state until now may be an earlier one
            than was seen, which the transaction brings up to date.
        Raises: RegistryError as `Watch.compare`: who writes to an earlier state makes a fork.
        """
        watch, own = Watch(self.called, self.place), self.authority.fingerprint
        with self.reported(), writing(self.engine) as connection:
            tree = self.tree_in(connection, lock=True)
            if not older:
                self.check_new(tree, watch)
                watch.compare(own, tree.leaves, tree.head, self.trust)
            transaction = Transaction(self, connection, tree, actor)
            yield transaction
            tree = self.tree_in(connection)
            if transaction.signed not in (None, tree.head):
                raise Fault("head_hash", "the database did not keep the head that was signed")
            self.check_new(tree, watch)
            watch.compare(own, tree.leaves, tree.head, self.trust)
        self._keep(tree.head)


class Transaction:
    """Records entered and changed, and the log of it, in one transaction of the database."""

    def __init__(self, ledger: Ledger, connection: Connection, tree: LogTree, actor: str) -> None:
        self.ledger = ledger
        self.connection = connection
        #: The log as the transaction found it.
        self.tree = tree
        #: The tree to which entries are added.
        self.growing = tree.tree.copy()
        #: The last head that was signed here.
        self.signed: Head | None = None
        self._actor = actor

    def records(self, query: AnySelect) -> list[Record]:
        """The records of a query made by `select_records`, none of which another process can change now."""
        return [record_of(row, self.ledger.authority) for row in self.connection.execute(query)]

    def enter(self, records: Sequence[Record], action: str) -> list[Record]:
        """Sign and store records whose ids are free, with an entry of `action` for each; returns them as stored.

        Raises: RegistryError if an id is that of a badge whose holder was erased.
        """
        # A record gets its salt as soon as it is signed.
        stored = [replace(one, salt=one.salt or secrets.token_hex(SALT_BYTES)) for one in records]
        if stored:
            own, log = [record.id for record in stored], schema.log.c
            erased = select(log.subject).where(log.subject.in_(own), log.action == ERASE)
            if (gone := self.connection.scalar(erased)) is not None:
                raise RegistryError(
                    f"id {gone} was that of a badge whose holder was erased, and is never issued again; print another "
                    "badge",
                    code="erased",
                    id=gone,
                )
            signer = self.ledger.signer()
            self.connection.execute(insert(schema.badges), [record.row(signer) for record in stored])
            self._log([(action, record.id, record.digest()) for record in stored])
        return stored

    def change(self, record: Record, action: str) -> Record:
        """Sign and store a record in the place of the one of its id, with an entry of `action`; returns it so."""
        values = record.row(self.ledger.signer())
        self.connection.execute(update(schema.badges).where(schema.badges.c.id == values.pop("id")).values(values))
        self._log([(action, record.id, record.digest())])
        return record

    def log(self, action: str, subject: str) -> None:
        """An entry of `action` that leaves no record of `subject`."""
        self._log([(action, subject, NO_RECORD)])

    def _log(self, done: list[tuple[str, str, str]]) -> None:
        """Add an entry for each (action, subject, SHA-256 of the record) to the log, and move the head.

        The head is over the entries as they are here, not as the database gives them back, which could be others.
        """
        signer = self.ledger.signer()
        rows = next_rows(signer, self.growing.size, done, self._actor)
        self.connection.execute(insert(schema.log), rows)
        for row in rows:
            self.growing.add(leaf_of(row["hash"]))
        self.signed = head = Head.over(self.growing)
        self.connection.execute(update(schema.authority).values(head_row(signer, head)))
