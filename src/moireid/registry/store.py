"""The Registry: enroll, and calls to audit, export and import.

It inherits its other methods from `queries.py`, `changes.py` and `public_view.py`.

An issued badge is never changed: enrolling the very same badge again returns the existing record, revoked or not.
What is added later, a revocation or measured figures, is signed and logged like the issue itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Sized
from functools import partial
from pathlib import Path

from sqlalchemy.engine import URL

from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.files import planned, whole_file
from moireid.registry.audit import audit
from moireid.registry.audit_findings import Audit
from moireid.registry.bundle.publish import Progress
from moireid.registry.canonical import utc_now
from moireid.registry.changes import RegistryChanges
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.note import VerifierKey
from moireid.registry.engine import chunks, default_url, read_url, sqlite_file
from moireid.registry.keys import Authority, account, checked_actor, key_path, keys_folder
from moireid.registry.ledger import Transaction, open_ledger
from moireid.registry.opening import new_authority
from moireid.registry.public_view import PublicView
from moireid.registry.record import Record, new_record
from moireid.registry.schema import badges, select_records
from moireid.registry.transfer import audited_copy, checked_copy, make_copy, merge, sign_anew


def open_registry(url: str | None, *, create: bool, actor: str | None = None) -> Registry:
    """The registry at an SQLAlchemy URL, or at `default_url()` for None.

    Parameters
    ----------
    url : str or None
        Such as ``sqlite:///people.sqlite3``.
    create : bool
        Make folder, file, tables and the authority's key pair if they are absent; if false, nothing is ever made.
    actor : str, optional
        The person or account that uses it, as the log names them; None for the account that runs this process.

    Returns
    -------
    Registry
        A context manager that closes its connections.

    Raises
    ------
    RegistryError
        If the URL is none, its driver is not known, the registry is absent, or the database cannot be opened,
        is no registry, or has another schema version; if no key can be written; or `actor` is no line of text.
    MissingExtraError
        If it is on PostgreSQL, and the driver is not installed.
    """
    who = account() if actor is None else checked_actor(actor)
    return Registry(open_ledger(_url(url), partial(new_authority, who) if create else None), who)


def _url(url: str | None) -> URL:
    return read_url(default_url() if url is None else url)


class Registry(RegistryChanges, PublicView):
    """An open registry; a context manager that closes its connections.

    Parameters
    ----------
    ledger : Ledger
        Tables and log.  `open_registry` makes one.
    actor : str
        The person or account that uses it, as the log names them.

    Raises
    ------
    RegistryError
        By every method if the database fails, or if a record that it would return is not as the authority signed it,
        or is not the newest version in the log; and by every method but `audit` if the registry was put back to an
        earlier state, forked or made anew since this user saw it.  Methods that write need the private key.
    """

    def by(self, actor: str) -> Registry:
        """Return the same open registry for another actor.

        Parameters
        ----------
        actor : str
            The person or account that uses it, as the log names them.

        Returns
        -------
        Registry
            It shares the connections; closing either closes both.

        Raises
        ------
        RegistryError
            If `actor` is no line of text, or is a studio's token.
        """
        return Registry(self._ledger, checked_actor(actor))

    def __enter__(self) -> Registry:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._ledger.engine.dispose()

    @property
    def fingerprint(self) -> str:
        """The fingerprint of the authority's public key, 32 hex digits."""
        return self._ledger.authority.fingerprint

    @property
    def authority(self) -> Authority:
        """The public half of the key by which the registry's authority signs."""
        return self._ledger.authority

    @property
    def key_path(self) -> Path:
        """Where the authority's private key is looked for.  Raises: RegistryError for a user without a home folder."""
        return key_path(self._ledger.authority)

    @property
    def key_here(self) -> Path | None:
        """The file of the authority's private key; None if it is not on this machine."""
        if keys_folder() is None or not self.key_path.exists():
            return None
        return self.key_path

    @property
    def remembered(self) -> bool:
        """Whether its state could be remembered, so that an earlier one will be noticed."""
        return self._ledger.remembered

    @property
    def file(self) -> Path | None:
        """The SQLite file that holds it; None if it is in another database."""
        return sqlite_file(self._ledger.url)

    def head(self) -> str:
        """Return the log's last entry.

        Returns
        -------
        str
            NUMBER:ROOT.
        """
        with self._ledger.snapshot() as connection:
            return str(self._ledger.tree_in(connection).head)

    def enroll(self, badge: Badge) -> Record:
        """Issue a badge.

        Parameters
        ----------
        badge : Badge
            With an id and a name.

        Returns
        -------
        Record
            The new record.  For the very same badge again it is the existing one, unchanged, even if it is revoked.

        Raises
        ------
        RegistryError
            If the badge has no id, or a name that cannot be claimed or holds invisible letters; if its id is issued
            already to another name or with another badge, or was an erased person's.
        SpecError
            If the badge breaks its own schema.

        Notes
        -----
        `look_alikes` finds people whose names look like this one.
        """
        return self.enroll_many([badge])[0]

    def enroll_many(self, issued: Iterable[Badge], progress: Progress | None = None) -> list[Record]:
        """Issue many badges, five hundred at a time.

        Parameters
        ----------
        issued : iterable of Badge
            A badge that is enrolled already stays as it is, so an interrupted batch can be run again.
        progress : callable, optional
            Called with badges done and in all, None if `issued` has no length.

        Returns
        -------
        list of Record
            As `enroll`, in the order of the badges.

        Raises
        ------
        RegistryError
            As `enroll`, of the first badge that cannot be issued: none of its five hundred is, and those before are.
        SpecError
            As `enroll`.
        """
        total = len(issued) if isinstance(issued, Sized) else None
        done: list[Record] = []
        for some in chunks(issued):
            records = [new_record(badge, self.shown_url, utc_now()) for badge in some]
            with self._ledger.writing(self.actor) as transaction:
                done += _enter(transaction, records)
            if progress:
                progress(len(done), total)
        return done

    def audit(
        self,
        progress: Progress | None = None,
        since: Sequence[Checkpoint] = (),
        witnesses: Sequence[VerifierKey] = (),
    ) -> Audit:
        """Check the whole log and all records, and report every fault.

        Parameters
        ----------
        progress : callable, optional
            Called with entries and records done and in all.
        since : sequence of Checkpoint
            Checkpoints that others keep; the log must still begin as they say.
        witnesses : sequence of VerifierKey
            All of them must have signed one of these checkpoints.

        Returns
        -------
        Audit
            Its `sound` is true if no fault was found.

        Raises
        ------
        RegistryError
            If a checkpoint does not bear the signature of the authority that it names.

        Notes
        -----
        `moireid.registry.audit` lists what an audit cannot show.
        """
        return audit(self._ledger, progress, since, witnesses)

    def export(self, path: Path | str, *, overwrite: bool = False, progress: Progress | None = None) -> int:
        """Copy records, log and public key to a file, whole or not at all: a registry of its own, without the key.

        Parameters
        ----------
        path : Path or str
            The file, in SQLite's format.
        overwrite : bool
            Whether an older file may be replaced.
        progress : callable, optional
            Called with entries and records checked and in all.

        Returns
        -------
        int
            The number of records.

        Raises
        ------
        RegistryError
            If something in the registry is not as signed.
        SpecError
            If the file exists and `overwrite` is false, or cannot be written.
        """
        planned([path := Path(path)], overwrite=overwrite, kept=[self.file])
        # One state of the registry, checked in the copy.  Badges can be printed from it.
        ledger = self._ledger
        with whole_file(path, private=True) as new, ledger.reported(), audited_copy(ledger, new, progress) as copy:
            return copy.count()


def _enter(transaction: Transaction, records: Sequence[Record]) -> list[Record]:
    """Enter those records that are new, all of them or none; returns all of them as they are stored.

    Raises: RegistryError for the first that cannot be issued.
    """
    ids = [record.id for record in records]
    held = {one.id: one for one in transaction.records(select_records().where(badges.c.id.in_(ids)))}
    new: dict[str, Record] = {}
    for record in records:
        holder = held.get(record.id) or new.setdefault(record.id, record)
        if holder is not record:
            _check_same(record, holder)
    held |= {one.id: one for one in transaction.enter(list(new.values()), "enroll")}
    return [held[one] for one in ids]


def _check_same(record: Record, holder: Record) -> None:
    """Raise RegistryError unless both are of the very same badge."""
    # Texts of one badge may differ if a whole number is written with or without its point.
    if holder.badge_json != record.badge_json and holder.badge != record.badge:
        other = "with another badge " if holder.name == record.name else ""
        raise RegistryError(
            f"id {record.id} is issued already to {holder.name!r} {other}({holder.issued_at}), so {record.name!r} "
            "cannot have this badge; print one with another payload=",
            id=record.id,
            holder=holder.name,
            issued_at=holder.issued_at,
        )


def import_registry(path: Path | str, url: str | None, *, actor: str | None = None, new_key: bool = False) -> int:
    """Take in an export, all of it or nothing, and make the registry if it is absent; the same again changes nothing.

    Parameters
    ----------
    path : Path or str
        What `Registry.export` wrote.
    url : str or None
        As `open_registry`.  A registry that is made has no key of its own.
    actor : str, optional
        As `open_registry`.
    new_key : bool
        Sign all records anew, by the key of an empty registry, which is made if there is none.

    Returns
    -------
    int
        The number of records in the file.

    Raises
    ------
    RegistryError
        If the file is damaged or not sound, is another authority's and this registry is not empty, or contradicts
        this registry; if records must be signed and the private key is absent; and as `open_registry`.  Nothing is made
        if the file is at fault.
    """
    who = account() if actor is None else checked_actor(actor)
    with checked_copy(Path(path)) as copy:
        make = partial(new_authority, who) if new_key else partial(make_copy, copy)
        with Registry(open_ledger(_url(url), make), who) as registry:
            (sign_anew if new_key else merge)(copy, registry._ledger, who)
        return copy.count()
