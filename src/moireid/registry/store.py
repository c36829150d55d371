"""The Registry: enroll, and calls to audit, export and import.

It inherits its other methods from `queries.py`, `changes.py` and `public_view.py`.

An issued badge is never changed: enrolling the very same badge again returns the existing record, revoked or not.
What is added later, a revocation, a suspension or measured figures, is signed and logged like the issue itself.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence, Sized
from pathlib import Path
from types import TracebackType

from moireid.badge import Badge
from moireid.registry.audit import audit
from moireid.registry.audit_findings import Audit
from moireid.registry.batch import Batch, enter, same_or_conflict
from moireid.registry.canonical import utc_now
from moireid.registry.changes import RegistryChanges, expiry_day
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.cosignature import Quorum
from moireid.registry.engine import chunks, default_url, read_url, sqlite_file
from moireid.registry.keys import account, checked_actor, key_path, keys_folder
from moireid.registry.ledger import Ledger, open_ledger
from moireid.registry.look_alikes import LookAlikeWarning
from moireid.registry.public_view import PublicView
from moireid.registry.record import Record, new_record
from moireid.registry.transfer import Import, checked_copy, export, merge, sign_anew

#: At most this many people whose names look alike are named in a warning.
MOST_NAMED = 3

Progress = Callable[[int, int | None], None]


def open_registry(url: str | None, *, create: bool, make_authority: bool = True, actor: str | None = None) -> Registry:
    """The registry at an SQLAlchemy URL, or at `default_url()` for None.

    Parameters
    ----------
    url : str or None
        Such as ``sqlite:///people.sqlite3``.
    create : bool
        Make folder, file, tables and the authority's key pair if they are absent; if false, nothing is ever made.
    make_authority : bool
        If false, a new registry has no key of its own and awaits an import.
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
    parsed = read_url(default_url() if url is None else url)
    who = account() if actor is None else checked_actor(actor)
    return Registry(open_ledger(parsed, create=create, make_authority=make_authority, actor=who), who)


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

    def __init__(self, ledger: Ledger, actor: str) -> None:
        super().__init__(ledger)
        self.shown_url, self.actor = ledger.shown, actor

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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._ledger.engine.dispose()

    @property
    def fingerprint(self) -> str:
        """The fingerprint of the authority's public key, 32 hex digits."""
        return self._ledger.authority.fingerprint

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
        return str(self._ledger.head())

    def enroll(self, badge: Badge, *, warned: bool = False, expires: str | None = None) -> Record:
        """Issue a badge.

        Parameters
        ----------
        badge : Badge
            With an id and a name.
        warned : bool
            Whether the user was warned already of people whose names look like this one; then no warning is given.
        expires : str, optional
            The last day on which it counts, in UTC, such as 2027-05-03; None: it does not expire.

        Returns
        -------
        Record
            The new record.  For the very same badge again it is the existing one, unchanged, even if it is revoked.

        Raises
        ------
        RegistryError
            If the badge has no id, or a name that cannot be claimed or holds invisible letters; if its id is issued
            already to another name, with another badge or another day of expiry, or was an erased person's.
        SpecError
            If the badge breaks its own schema, or `expires` is no day, or is in the past.

        Warns
        -----
        LookAlikeWarning
            If the name looks like that of another enrolled person.
        """
        last_day = None if expires is None else expiry_day(expires)
        record = new_record(badge, self.shown_url, utc_now(), last_day)
        holder = self.by_id(record.id)
        if holder is not None:
            return same_or_conflict(record, holder)
        self._ledger.signer()
        # Looked up again under the write lock: else two processes could find the id free at once.
        entered, held = enter(self._ledger, [record], self.actor)
        self._warn([one.name for one in entered], warned=warned)
        return [*entered, *held][0]

    def enroll_many(
        self,
        issued: Iterable[Badge],
        progress: Progress | None = None,
        *,
        warned: bool = False,
        expires: str | None = None,
    ) -> Batch:
        """Issue many badges, five hundred at a time.

        Parameters
        ----------
        issued : iterable of Badge
            A badge that is enrolled already stays as it is, so an interrupted batch can be run again.
        progress : callable, optional
            Called with badges done and in all, None if `issued` has no length.
        warned : bool
            As `enroll`.
        expires : str, optional
            As `enroll`, of all of them.

        Returns
        -------
        Batch
            How many are new, and how many were there.

        Raises
        ------
        RegistryError
            As `enroll`, of the first badge that cannot be issued: none of its five hundred is, and those before are.
        SpecError
            As `enroll`.

        Warns
        -----
        LookAlikeWarning
            As `enroll`, once all are issued; of names in the list that look like each other, too.
        """
        last_day = None if expires is None else expiry_day(expires)
        total = len(issued) if isinstance(issued, Sized) else None
        enrolled = unchanged = revoked = 0
        names: list[str] = []
        try:
            for some in chunks(issued):
                records = [new_record(badge, self.shown_url, utc_now(), last_day) for badge in some]
                new, there = enter(self._ledger, records, self.actor)
                names += [one.name for one in new]
                enrolled, unchanged = enrolled + len(new), unchanged + len(there)
                revoked += sum(one.revoked_at is not None for one in there)
                if progress:
                    progress(enrolled + unchanged, total)
        finally:
            self._warn(names, warned=warned)
        return Batch(enrolled, unchanged, revoked)

    def _warn(self, names: Sequence[str], *, warned: bool) -> None:
        """Warn the caller's caller of names that look like others here; warned: that was done already."""
        for name, alike in ({} if warned else self.look_alikes(names)).items():
            others = ", ".join(f"{one.name} ({one.id})" for one in alike[:MOST_NAMED])
            text = f"the name {name!r} looks like {others}, who is enrolled, and is written in other letters or case"
            warnings.warn(text, LookAlikeWarning, stacklevel=3)

    def audit(
        self,
        progress: Progress | None = None,
        since: Sequence[Checkpoint] = (),
        quorum: Quorum | None = None,
    ) -> Audit:
        """Check the whole log and all records, and report every fault.

        Parameters
        ----------
        progress : callable, optional
            Called with entries and records done and in all.
        since : sequence of Checkpoint
            Checkpoints that others keep; the log must still begin as they say.
        quorum : Quorum, optional
            The witnesses that must have signed one of these checkpoints.

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
        return audit(self._ledger, progress, since, quorum)

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
        return export(self._ledger, Path(path), overwrite=overwrite, progress=progress)


def import_registry(path: Path | str, url: str | None, *, actor: str | None = None, new_key: bool = False) -> Import:
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
    Import
        How many records are new, changed and unchanged.

    Raises
    ------
    RegistryError
        If the file is damaged or not sound, is another authority's and this registry is not empty, or contradicts
        this registry; if records must be signed and the private key is absent; and as `open_registry`.  Nothing is made
        if the file is at fault.
    """
    with (
        checked_copy(Path(path)) as copy,
        open_registry(url, create=True, make_authority=new_key, actor=actor) as registry,
    ):
        return (sign_anew if new_key else merge)(copy, registry._ledger, registry.actor)
