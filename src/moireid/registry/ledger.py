"""The ledger: a database with its authority, and the transactions that write to both tables and log.

Every write goes through `Ledger.writing`: it locks the head, checks it against the log, and gives a `Transaction`.
That signs each record, adds an entry to the log and its tree, and moves the head, all of it or nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace

from sqlalchemy import Connection, Engine, delete, insert, select, update
from sqlalchemy.engine import URL

from moireid.errors import RegistryError
from moireid.provenance import Standing
from moireid.registry import schema
from moireid.registry.engine import (
    AnyRow,
    AnySelect,
    chunks,
    connect,
    show_url,
    snapshot,
    sqlite_file,
    translated,
    writing,
)
from moireid.registry.keys import Authority, Signer, key_of, new_salt
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
from moireid.registry.opening import prepare
from moireid.registry.record import Fault, Record, record_of, tampered
from moireid.registry.rollback import LogState, compared, standing_of
from moireid.registry.seen import Memory, recall, remember


def open_ledger(url: URL, *, create: bool, make_authority: bool, actor: str) -> Ledger:
    """What `open_registry` opens, at a URL that `read_url` has read; actor: who makes it, if it is absent."""
    _look_for_file(url, create=create)
    engine = connect(url, create=create)
    try:
        with translated(url):
            public_key, made = prepare(engine, show_url(url), create=create, make_authority=make_authority, actor=actor)
        ledger = Ledger(engine, url, public_key)
        if made:
            ledger.remember()
        return ledger
    except RegistryError:
        engine.dispose()
        raise


class Ledger:
    """A database, and the authority whose signatures count in it."""

    def __init__(self, engine: Engine, url: URL, public_key: str | None) -> None:
        """Raises: RegistryError if `public_key` is no key; it is None for a registry that awaits an import."""
        self.engine = engine
        self.url = url
        self.shown = show_url(url)
        #: Names the registry in messages.
        self.called = f"registry {self.shown}"
        #: Identifies the registry among all that this user opens; the password is not part of it.
        self.place = url.set(password=None).render_as_string()
        #: The fingerprint of the one authority that counts; None for the one that was seen at this place first.
        self.trust: str | None = None
        #: Whether it is compared with what was seen before, and whether its state could be remembered.
        self.checked, self.remembered = True, True
        #: The head that witnesses have seen, if a reader asks for that (`Registry.require_witnesses`); else None.
        self.witnessed: Head | None = None
        #: The log as an earlier transaction read it.
        self._tree: LogTree | None = None
        self._signer: Signer | None = None
        self._authority: Authority | None = None
        if public_key is not None:
            self.adopt(public_key)

    def adopt(self, public_key: str) -> None:
        """Make `public_key`, 64 hex digits, the authority's key.  Raises: RegistryError if it is no key."""
        try:
            self._authority = Authority(public_key)
        except (TypeError, ValueError) as error:
            raise tampered(self.shown, Fault("public_key", "its public key is none")) from error
        self._signer = None

    @property
    def authority(self) -> Authority:
        """The authority whose signatures count.  Raises: RegistryError if the registry awaits an import."""
        if self._authority is None:
            raise RegistryError(
                f"registry {self.shown} has no authority yet; run `moireid registry init`, or import an export"
            )
        return self._authority

    @property
    def has_authority(self) -> bool:
        """Whether there is an authority; only a registry that awaits an import has none."""
        return self._authority is not None

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

    def unchecked(self) -> Ledger:
        """The same ledger, not compared with what was seen before: for those who report what is wrong with it."""
        other = copy(self)
        other.checked = False
        return other

    def standing(self) -> Standing:
        """Compare it with what was seen of it before.  Raises: RegistryError as `rollback.standing_of`."""
        memory = recall(self.place)
        with self.reported(), snapshot(self.engine) as connection:
            return self._compared(connection, memory)

    def _compared(self, connection: Connection, memory: Memory) -> Standing:
        standing = standing_of(self._state(connection), memory, self.trust)
        self.remembered = standing.remembered
        return standing

    def _state(self, connection: Connection) -> LogState:
        """Its state in a transaction.  Raises: RegistryError if the head is not as signed."""
        tree = self.tree_in(connection)
        return LogState(self.called, self.place, self.authority.fingerprint, tree.head, tree.leads_from)

    def remember(self) -> None:
        """Remember its present state, whatever was seen at this place before: it was made here."""
        with self.reported(), snapshot(self.engine) as connection:
            self._keep(self._state(connection))

    def _keep(self, state: LogState) -> None:
        self.remembered = remember(state.place, state.fingerprint, state.head)

    def rows(self, query: AnySelect) -> list[AnyRow]:
        """All rows of a query, in a transaction of its own."""
        with self.snapshot() as connection:
            return list(connection.execute(query))

    def record(self, row: AnyRow) -> Record:
        """The record of a row of `select_records`.  Raises: RegistryError if it is not as it was signed."""
        with self.reported():
            return record_of(row, self.authority)

    def head(self) -> Head:
        """The log's head.  Raises: RegistryError if its signature is wrong, or it is not the end of the log."""
        with self.snapshot() as connection:
            return self.tree_in(connection).head

    def tree_in(self, connection: Connection, *, lock: bool = False) -> LogTree:
        """The tree up to the log's head, within a transaction; with `lock`, other writers wait until it ends.

        Raises: RegistryError as `head`.
        """
        query = select(schema.authority)
        row = connection.execute(query.with_for_update() if lock else query).first()
        if row is None or row.public_key != self.authority.public_hex:
            raise self._other_authority()
        last = connection.execute(schema.last_entry()).first()
        with self.reported():
            if last is not None and not isinstance(last.seq, int):
                # The tables were exchanged since they were looked at; text is the last, so all others are numbers.
                raise Fault("tables", "the numbers of the log's entries are none")
            head = check_head(row, None if last is None else last.seq, self.authority)
            self._tree = tree = LogTree(connection, head, self._tree)
        return tree

    @contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """A connection that sees one state of the registry, whatever is written meanwhile.

        Raises: RegistryError as `rollback.standing_of`: whatever is shown, judged, exported or counted is read here.
        """
        compares = self.checked and self.has_authority
        memory: Memory = recall(self.place) if compares else (None, {})
        with self.reported(), snapshot(self.engine) as connection:
            if compares:
                self._compared(connection, memory)
            yield connection

    def check_newest(self, record: Record) -> None:
        """Check the log from the record's newest entry to its signed head.

        Reading a record compares it with its newest entry among those that are present.  An attacker who can write to
        the database could put back a record from before its revocation, and change the revocation's entry, or take it
        out.  A proof that the older entry is in the tree does not show that.
        Raises: RegistryError if an entry on the way was changed or taken out, or is about another version of the
            record; or if witnesses must have seen it, and it is later than they have.  What bars a badge counts unseen.
        Source: the root over all entries is signed; so no signature on the way counts.  100,000 entries take about a
            second.
        """
        with self.snapshot() as connection:
            tree = self.tree_in(connection)
            newest = tree.newest_entry(record.id, record.digest())
            seen = self.witnessed
            if seen is not None and tree.consistency(seen.seq, bytes.fromhex(seen.hash)) is None:
                raise Fault("forked", f"the log's first {seen.seq} entries are not those that witnesses have seen")
        if seen is not None and newest > seen.seq and record.barred() is None:
            raise RegistryError(
                f"the record of badge {record.id} is of log entry {newest}, and witnesses have seen {seen.seq}; "
                "get a newer checkpoint from those who run the registry",
                code="not_witnessed",
            )

    @contextmanager
    def writing(self, actor: str, *, older: bool = False) -> Iterator[Transaction]:
        """A transaction, alone among those that write; committed at the end, rolled back if an exception leaves it.

        Its head is remembered as soon as it is committed, so that no earlier one passes from then on.
        Parameters: actor: who writes, as the log is to name them; older: the state until now may be an earlier one
            than was seen, which the transaction brings up to date.
        Raises: RegistryError as `rollback.standing_of`: who writes to an earlier state makes a fork.
        """
        memory, after = recall(self.place), copy(self)
        with self.reported(), writing(self.engine) as connection:
            transaction = Transaction(self, connection, self.tree_in(connection, lock=True), actor)
            if not older:
                compared(self._state(connection), memory, self.trust)
            yield transaction
            state = after._state(connection)
            if transaction.signed not in (None, state.head):
                raise Fault("head_hash", "the database did not keep the head that was signed")
            compared(state, memory, self.trust)
        self._keep(state)

    @contextmanager
    def clearing(self, successor: Authority) -> Iterator[Connection]:
        """A transaction in which the tables are empty, so that another authority's content can be copied in.

        Raises: RegistryError if the registry holds more than the first entry of its log.
        """
        after = copy(self)
        after.adopt(successor.public_hex)
        with self.reported(), writing(self.engine) as connection:
            row = connection.execute(select(schema.authority).with_for_update()).first()
            own = self._authority.public_hex if self._authority else None
            if (row.public_key if row else None) != own:
                raise self._other_authority()
            last = connection.execute(schema.last_entry()).first()
            if (last is not None and last.seq > 1) or connection.execute(select(schema.badges.c.id).limit(1)).first():
                raise RegistryError(
                    f"registry {self.shown} holds records of authority {self.authority.fingerprint}, and this export "
                    f"is of {successor.fingerprint}; import it into an empty registry"
                )
            for table in (schema.authority, schema.log, schema.badges):
                connection.execute(delete(table))
            yield connection
            state = after._state(connection)
        self.adopt(successor.public_hex)
        self._keep(state)

    def _other_authority(self) -> RegistryError:
        return RegistryError(
            f"registry {self.shown} has come under another authority since it was opened; open it again",
            code="public_key",
        )


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
        return [self.ledger.record(row) for row in self.connection.execute(query)]

    def enter(self, records: Sequence[Record], action: str) -> list[Record]:
        """Sign and store records whose ids are free, with an entry of `action` for each; returns them as stored.

        Raises: RegistryError if an id is that of a badge whose holder was erased.
        """
        stored = [_salted(record) for record in records]
        if stored:
            for gone in erased_among(self.connection, [record.id for record in stored]):
                raise erased_id(gone)
            signer = self.ledger.signer()
            self.connection.execute(insert(schema.badges), [record.row(signer) for record in stored])
            self._log([(action, record.id, record.digest()) for record in stored])
        return stored

    def change(self, record: Record, action: str) -> Record:
        """Sign and store a record in the place of the one of its id, with an entry of `action`; returns it so."""
        record = _salted(record)
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
        self.signed = head = Head(self.growing.size, self.growing.root().hex())
        self.connection.execute(update(schema.authority).values(head_row(signer, head)))


def _salted(record: Record) -> Record:
    """A record gets its salt as soon as it is signed."""
    return record if record.salt is not None else replace(record, salt=new_salt())


def erased_among(connection: Connection, ids: Sequence[str]) -> list[str]:
    """Those of some ids whose holders were erased."""
    found: list[str] = []
    for some in chunks(ids):
        query = select(schema.log.c.subject).where(schema.log.c.subject.in_(some), schema.log.c.action == ERASE)
        found += connection.scalars(query)
    return found


def erased_id(badge_id: str) -> RegistryError:
    """The error for an id that cannot be issued again."""
    return RegistryError(
        f"id {badge_id} was that of a badge whose holder was erased, and is never issued again; print another badge",
        code="erased",
        id=badge_id,
    )


def _look_for_file(url: URL, *, create: bool) -> None:
    """For an SQLite file: make its folder, or check that the file exists, because SQLite would create a missing one."""
    path = sqlite_file(url)
    if path is None:
        return
    try:
        if create:
            path.parent.mkdir(parents=True, exist_ok=True)
        else:
            path.stat()
    except (OSError, ValueError) as error:
        if not create and isinstance(error, (FileNotFoundError, NotADirectoryError)):
            raise RegistryError(
                f"there is no registry at {show_url(url)}; enroll someone first, or run `moireid registry init`"
            ) from error
        reason = error.strerror if isinstance(error, OSError) else error
        what = f"folder {path.parent} cannot be made" if create else f"registry {show_url(url)} cannot be reached"
        raise RegistryError(f"{what} ({reason}); give another URL") from error
