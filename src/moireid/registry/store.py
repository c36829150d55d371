"""The Registry: enroll, what is decided later and what it is read by (`face/`), calls to audit, export and import.

An issued badge is never changed: enrolling the very same badge again returns the record there is, revoked or not.
What is added later, a revocation, a suspension or measured figures, is signed and logged like the issue itself.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType

from moireid.badge import Badge
from moireid.errors import RegistryError
from moireid.registry.audit import Audit, audit
from moireid.registry.batch import Batch, enroll_many, same_or_conflict
from moireid.registry.canonical import utc_now
from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.checkpoints.seen import remember
from moireid.registry.engine import default_url, read_url
from moireid.registry.face.deciding import Deciding, locked
from moireid.registry.face.outward import Outward, expiry_day
from moireid.registry.keys import account, checked_actor, key_path
from moireid.registry.ledger import Ledger, open_ledger
from moireid.registry.look_alikes import LookAlikeWarning
from moireid.registry.maintenance.erasure import ErasureResult, erase_actor, erase_person
from moireid.registry.record import Record, new_record, storable_json
from moireid.registry.schema import badges, select_records
from moireid.registry.transfer.export import export_json
from moireid.registry.transfer.merge import Import, checked_copy, import_json, merge
from moireid.registry.transfer.rotate import KeyRotation, rotate

#: So many people of names that look alike are named in a warning.
MOST_TOLD = 3

Progress = Callable[[int, int | None], None]


def open_registry(url: str | None, *, create: bool, make_authority: bool = True, actor: str | None = None) -> Registry:
    """The registry at an SQLAlchemy URL, or at `default_url()` for None.

    Parameters
    ----------
    url : str or None
        Such as ``sqlite:///people.sqlite3``.
    create : bool
        Make folder, file, tables and the authority's key pair where they are absent; without it nothing is ever made.
    make_authority : bool
        Without it a new registry has no key of its own and awaits an import.
    actor : str, optional
        Who does what is done with it, as the log names them; None for the account that this process runs as.

    Returns
    -------
    Registry
        A context manager that closes its connections.

    Raises
    ------
    RegistryError
        Where the URL is none, its driver is not known, the registry is absent, or what is there cannot be opened,
        is no registry, or has another schema version; where no key can be written; or `actor` is no line of text.
    MissingExtraError
        Where it lies on PostgreSQL, and its driver is not installed.

    Notes
    -----
    A registry of schema version 2 is brought to this version; older programs cannot open it then.
    """
    parsed = read_url(default_url() if url is None else url)
    who = account() if actor is None else checked_actor(actor)
    return Registry(open_ledger(parsed, create=create, make_authority=make_authority, actor=who), who)


class Registry(Deciding, Outward):
    """An open registry; a context manager that closes its connections.

    Parameters
    ----------
    ledger : Ledger
        Tables and log.  `open_registry` makes one.
    actor : str
        Who does what is done with it.

    Raises
    ------
    RegistryError
        By every method where the database fails, and where a record that it would return is not as the authority signed
        it, or is not the version that the log has last.  Those that write need the private key.
    """

    def __init__(self, ledger: Ledger, actor: str) -> None:
        super().__init__(ledger)
        self.shown_url, self.actor = ledger.shown, actor

    def by(self, actor: str) -> Registry:
        """Give the same open registry, for somebody else to act on.

        Parameters
        ----------
        actor : str
            Who does what is done with it, as the log names them.

        Returns
        -------
        Registry
            It shares the connections; closing either closes both.

        Raises
        ------
        RegistryError
            Where `actor` is no line of text, or a studio's token.
        """
        return Registry(self._ledger, checked_actor(actor))

    def __enter__(self) -> Registry:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections; if something was written, remember its head, so that no earlier one passes later."""
        if self._ledger.wrote:
            self._ledger.wrote = False
            with suppress(RegistryError):
                own, turned = self._ledger.authority.fingerprint, self._ledger.rotations()
                remember(self._ledger.place, own, self._ledger.head(), turned)
        self._ledger.engine.dispose()

    @property
    def fingerprint(self) -> str:
        """The fingerprint of the authority's public key, 32 hex digits."""
        return self._ledger.authority.fingerprint

    @property
    def key_path(self) -> Path:
        """Where the authority's private key is looked for; it need not be there."""
        return key_path(self._ledger.authority)

    def head(self) -> str:
        """Give the log's last entry.

        Returns
        -------
        str
            SEQUENCE:HASH.  Noted elsewhere, it tells a registry that was put back from one that grew.
        """
        return str(self._ledger.head())

    def enroll(self, badge: Badge, *, told: bool = False, expires: str | None = None) -> Record:
        """Issue a badge.

        Parameters
        ----------
        badge : Badge
            With an id and a name.
        told : bool
            Whether whoever issues it was told already of people whose names look like this one.
        expires : str, optional
            The last day on which it counts, in UTC, such as 2027-05-03; None: it counts without an end.

        Returns
        -------
        Record
            The new record.  For the very same badge again it is the first one, unchanged, and revoked if it was.

        Raises
        ------
        RegistryError
            Where the badge has no id, or a name that cannot be claimed or holds letters that nobody sees; where its id
            is issued already to another name, with another badge or another day of expiry, or was an erased person's.
        SpecError
            Where the badge breaks its own schema, or `expires` is no day to come.

        Warns
        -----
        LookAlikeWarning
            Where the name looks like that of somebody else who is enrolled.
        """
        last_day = None if expires is None else expiry_day(expires)
        record = new_record(badge, self.shown_url, utc_now(), last_day)
        holder = self.by_id(record.id)
        if holder is None:
            self._ledger.signer()
            with self._ledger.writing(self.actor) as transaction:
                # Looked up again where nobody else can write: else two could find the id free at once.
                holders = transaction.records(select_records().where(badges.c.id == record.id))
                if not holders:
                    (record,) = transaction.enter([record], "enroll")
            if not holders:
                self._warn([record.name], told=told)
                return record
            holder = holders[0]
        return same_or_conflict(record, holder)

    def enroll_many(
        self,
        issued: Iterable[Badge],
        progress: Progress | None = None,
        *,
        told: bool = False,
        expires: str | None = None,
    ) -> Batch:
        """Issue many badges, a thousand at a time.

        Parameters
        ----------
        issued : iterable of Badge
            What is enrolled already stays as it is, so a batch that was interrupted can be run again.
        progress : callable, optional
            Called with badges done and in all, None where `issued` has no length.
        told : bool
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
            As `enroll`, of the first badge that cannot be issued; those before it are.
        SpecError
            As `enroll`.

        Warns
        -----
        LookAlikeWarning
            As `enroll`, once all are issued; of names in the list that look like each other, too.
        """
        names: list[str] = []
        try:
            return enroll_many(
                self._ledger,
                issued,
                self.actor,
                progress,
                lambda new: names.extend(one.name for one in new),
                None if expires is None else expiry_day(expires),
            )
        finally:
            self._warn(names, told=told)

    def rotate_key(self, progress: Progress | None = None) -> KeyRotation:
        """Give the authority a new key, by a log entry that the old and the new one sign.

        Parameters
        ----------
        progress : callable, optional
            Called with records done, and None.

        Returns
        -------
        Rotated
            Both fingerprints, and the new head.

        Raises
        ------
        RegistryError
            Where the old key is not here, a new one cannot be kept, or a record is not as it was signed.

        Notes
        -----
        Other programs that have the registry open must open it again.
        """
        return rotate(self._ledger, self.actor, progress)

    def store_as_built(self, badge_id: str, document_json: str) -> Record:
        """Hold the newest measured figures of a badge; the same again changes nothing.

        Parameters
        ----------
        badge_id : str
            Hex digits of any case.
        document_json : str
            A JSON object.

        Returns
        -------
        Record
            The record with these figures.

        Raises
        ------
        RegistryError
            Where the id is not issued, or the text is no JSON object that can be stored.
        """
        try:
            document = json.loads(document_json)
        except (json.JSONDecodeError, RecursionError) as error:
            raise RegistryError(f"the measured figures of {badge_id[:40]!r} are not JSON ({error})") from error
        if not isinstance(document, dict):
            raise RegistryError(f"the measured figures of {badge_id[:40]!r} are no JSON object; give one")
        text = storable_json(document, f"the document of measured figures of {badge_id[:40]!r}", "measure anew")
        record = self.by_id(badge_id)
        if record is None:
            raise RegistryError(
                f"no badge of id {badge_id[:40]!r} is in registry {self.shown_url}; enroll it before its figures"
            )
        with self._ledger.writing(self.actor) as transaction:
            record = locked(transaction, record)
            if record.as_built != text:
                record = replace(record, as_built=text, as_built_at=utc_now())
                record = transaction.change(record, "as_built")
        return record

    def erase(self, claim: str) -> ErasureResult:
        """Erase a person on their wish, for good; again only cleans the database again.

        Parameters
        ----------
        claim : str
            A name or an id, as `find`.

        Returns
        -------
        Erased
            When, and what may be left.

        Raises
        ------
        RegistryError
            Where nobody or more than one is meant.
        """
        return erase_person(self._ledger, claim, self.actor)

    def erase_actor(self, name: str) -> ErasureResult:
        """Erase who did something here: the log keeps what was done, and no longer by whom.

        Parameters
        ----------
        name : str
            As `entries` gives it.

        Returns
        -------
        Erased
            When; its subject is what stands for the actor in the log.

        Raises
        ------
        RegistryError
            Where the log names nobody so, or they would erase themself.
        """
        return erase_actor(self._ledger, name, self.actor)

    def _warn(self, names: Sequence[str], *, told: bool) -> None:
        """Warn the caller's caller of names that look like others here."""
        for name, alike in ({} if told else self.look_alikes(names)).items():
            others = ", ".join(f"{one.name} ({one.id})" for one in alike[:MOST_TOLD])
            text = f"the name {name!r} looks like {others}, who is enrolled, and is written in other letters or case"
            warnings.warn(text, LookAlikeWarning, stacklevel=3)

    def audit(
        self,
        expected_head: str | None = None,
        progress: Progress | None = None,
        since: Sequence[Checkpoint] = (),
    ) -> Audit:
        """Walk over the whole log and all records, and report what does not hold.

        Parameters
        ----------
        expected_head : str, optional
            A head noted earlier, SEQUENCE:HASH.
        progress : callable, optional
            Called with entries and records done and in all.
        since : sequence of Checkpoint
            Checkpoints that others hold; the log must still begin as they say.

        Returns
        -------
        Audit
            Its `sound` is true where everything holds.

        Raises
        ------
        RegistryError
            Where `expected_head` is none, or a checkpoint does not bear the signature of the authority that it names.

        Notes
        -----
        What an audit cannot show is told in `moireid.registry.audit`.
        """
        return audit(self._ledger, expected_head, progress, since)

    def export_json(self, path: Path | str, *, overwrite: bool = False, progress: Progress | None = None) -> int:
        """Write records, log and public key to a JSON file, whole or not at all.

        Parameters
        ----------
        path : Path or str
            The file.
        overwrite : bool
            Whether an older file may be replaced.
        progress : callable, optional
            Called with records done and in all.

        Returns
        -------
        int
            The number of records.

        Raises
        ------
        RegistryError
            Where something in the registry is not as signed.
        SpecError
            Where the file exists and `overwrite` is false, or cannot be written.
        """
        return export_json(self._ledger, Path(path), overwrite=overwrite, progress=progress)

    def import_json(self, path: Path | str) -> Import:
        """Take in what `export_json` wrote, all of it or nothing; the same again changes nothing.

        Parameters
        ----------
        path : Path or str
            The file.

        Returns
        -------
        Import
            How many records are new, changed and unchanged.

        Raises
        ------
        RegistryError
            Where the file is damaged or not sound, is another authority's and this registry is not empty, or says
            otherwise than this registry; or where records must be signed and the private key is absent.
        """
        return import_json(self._ledger, Path(path), self.actor)


def import_registry(path: Path | str, url: str | None, *, actor: str | None = None) -> Import:
    """Take in an export as `Registry.import_json` does, and make the registry where it is absent.

    Parameters
    ----------
    path : Path or str
        What `Registry.export_json` wrote.
    url : str or None
        As `open_registry`.  A registry that is made has no key of its own.
    actor : str, optional
        As `open_registry`.

    Returns
    -------
    Import
        How many records are new, changed and unchanged.

    Raises
    ------
    RegistryError
        As `Registry.import_json` and `open_registry`; nothing is made where the file is at fault.
    """
    with (
        checked_copy(Path(path)) as copy,
        open_registry(url, create=True, make_authority=False, actor=actor) as registry,
    ):
        return merge(copy, registry._ledger, registry.actor)
