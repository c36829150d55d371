"""A log compared with checkpoints that others kept, and a registry or bundle compared with what was seen last.

A witness is any second holder of checkpoints: a file, a folder of them, or a web address.  The log is compared with
its checkpoints entry by entry.  A registry, or a bundle of it, is also compared with the authority that the user
trusts.
"""

from __future__ import annotations

import re
import urllib.error
import urllib.request
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Protocol

from moireid.errors import RegistryError, SpecError
from moireid.provenance import Standing
from moireid.registry.checkpoints.checkpoint import ORIGIN, Checkpoint, checkpoint_from, leaf_of
from moireid.registry.checkpoints.merkle import Tree
from moireid.registry.checkpoints.seen import authority_at, last_head, remember, successor_of
from moireid.registry.keys import FINGERPRINT_DIGITS, Authority
from moireid.registry.log import Head, Rotation
from moireid.registry.record import Fault

#: A checkpoint is 250 bytes, more with the lines of witnesses; and how long a web server may take.
LONGEST, WAIT_S = 65536, 15.0


def checkpoints_from(source: str) -> list[Checkpoint]:
    """The checkpoints that a witness holds.

    Parameters
    ----------
    source : str
        Path of a checkpoint, or of a folder of them, or an address that begins with http:// or https://.

    Returns
    -------
    list of Checkpoint
        At least one; their signatures are not checked yet.

    Raises
    ------
    RegistryError
        If there is none, or it cannot be read.
    """
    if source.startswith(("http://", "https://")):
        return [checkpoint_from(_fetched(source), source)]
    path = Path(source)
    if not path.is_dir():
        return [checkpoint_from(_read(path), source)]
    texts = {one: _read(one) for one in sorted(path.iterdir()) if one.is_file()}
    found = [checkpoint_from(text, str(one)) for one, text in texts.items() if text.startswith(ORIGIN)]
    if not found:
        raise RegistryError(f"no file in folder {source} is a checkpoint; give one that holds some")
    return found


class Watch:
    """Compares a log with checkpoints, while its entries are read one by one."""

    def __init__(
        self, checkpoints: Sequence[Checkpoint], authority: Authority, former: Sequence[Authority] = ()
    ) -> None:
        """Parameters: former: the authority's earlier keys.

        Raises: RegistryError if a checkpoint names this authority and does not bear its signature.
        """
        keys = {one.fingerprint: one for one in (*former, authority)}
        self._own = [one for one in checkpoints if one.fingerprint in keys]
        self._others = [one for one in checkpoints if one.fingerprint not in keys]
        for one in self._own:
            one.check(keys[one.fingerprint], f"of {one.date}")
        self._authority, self._tree = authority, Tree()
        self._forked: list[Checkpoint] = []

    def entry(self, entry_hash: str) -> None:
        """Take the next entry."""
        if not self._own:
            return
        try:
            self._tree.add(leaf_of(entry_hash))
        except ValueError:
            # The audit itself reports such a hash; here it only must not be taken for the right one.
            self._tree.add(b"")
        due = [one for one in self._own if one.size == self._tree.size]
        self._forked += [one for one in due if one.root != self._tree.root()]

    def findings(self, head: Head | None) -> Iterator[tuple[Fault, int | None]]:
        """The faults, each with the entry that it is about; head: the log's end, None if its signature is not valid."""
        for one in self._others:
            text = (
                f"the registry is signed by authority {self._authority.fingerprint}, and the checkpoint of {one.date} "
                f"by {one.fingerprint}: its key was replaced"
            )
            yield Fault("key_replaced", text), None
        for one in self._forked:
            text = (
                f"the log's first {one.size} entries are not those of the checkpoint of {one.date}: it was forked, and "
                "something was written in the place of what had been signed"
            )
            yield Fault("forked", text), one.size
        size = self._tree.size
        for one in self._own:
            if one.size <= size:
                continue
            noted = f"the log ends at entry {size}, and the checkpoint of {one.date} names {one.size} entries"
            if head is None:
                yield Fault("log_cut", f"{noted}: its end was cut off"), one.size
            else:
                text = f"{noted}: the registry was rolled back, an earlier state was put back"
                yield Fault("rolled_back", text), one.size


def _read(path: Path) -> str:
    try:
        with path.open("rb") as stream:
            return stream.read(LONGEST).decode("utf-8", errors="replace")
    except OSError as error:
        raise RegistryError(
            f"checkpoint {path} cannot be read ({error.strerror}); give the path of a file or folder, or a web address"
        ) from error


def _fetched(address: str) -> str:
    try:
        with urllib.request.urlopen(address, timeout=WAIT_S) as answer:
            return bytes(answer.read(LONGEST)).decode("utf-8", errors="replace")
    except (OSError, ValueError, urllib.error.URLError) as error:
        reason = getattr(error, "reason", error)
        raise RegistryError(f"checkpoint {address} cannot be fetched ({reason}); check the address") from error


def as_fingerprint(text: str) -> str:
    """A fingerprint as people write it: any case, with blanks or colons.  Raises: SpecError if it is none."""
    digits = re.sub(r"[\s:]", "", text).lower()
    if not re.fullmatch(f"[0-9a-f]{{{FINGERPRINT_DIGITS}}}", digits):
        raise SpecError(
            f"fingerprint {text[:80]!r} is none; give the {FINGERPRINT_DIGITS} hex digits that `moireid registry init` "
            "prints for those who run the registry"
        )
    return digits


class SeenLog(Protocol):
    """A registry or a bundle of one, as it is compared with what was seen before."""

    #: Names it in messages, and identifies it among all that this user opens.
    called: str
    place: str

    @property
    def authority(self) -> Authority:
        """The authority that signs it."""

    def head(self) -> Head:
        """Its last entry."""

    def hash_at(self, seq: int) -> str | None:
        """The hash of an entry; None if there is no such entry."""

    def rotations(self) -> list[Rotation]:
        """The proven changes of its authority's key, oldest first."""


def standing_of(log: SeenLog, trust: str | None = None, expires: str | None = None) -> Standing:
    """Compare a registry or a bundle with what was seen of it before, and remember its present state.

    Parameters
    ----------
    log : SeenLog
        The ledger of an open registry, or a bundle.
    trust : str, optional
        The fingerprint of the one authority that counts; None for the one that was seen at this place first.
    expires : str, optional
        Until when a bundle counts.

    Returns
    -------
    Standing
        Its authority and head.

    Raises
    ------
    RegistryError
        If it is signed by another authority or by a key that was given up, was put back to an earlier state, or was
        forked; `details["code"]` is "key_replaced", "key_given_up", "two_successors", "rolled_back" or "forked".  Also
        if its head is not as signed.
    SpecError
        If `trust` is no fingerprint.

    Notes
    -----
    A user who trusts an earlier key of the authority, or has seen it here, then trusts the present one.
    """
    own, turned = log.authority.fingerprint, log.rotations()
    followed = _check_authority(log, trust, turned)
    head, last = _checked_head(log, own)
    _check_successors(log, turned, named=trust is not None and as_fingerprint(trust) == own)
    if followed is not None:
        # What was seen under the earlier key must still be there.
        _, last = _checked_head(log, followed)
        # Else a user who still trusts that key would not notice a return to a state before the change.
        remember(log.place, followed, head)
    kept = remember(log.place, own, head, turned)
    return Standing(own, str(head), expires, new=last is None and trust is None, remembered=kept)


def check_head(log: SeenLog) -> None:
    """Raise RegistryError if the log was longer before: writing to an earlier state would fork it."""
    turned = log.rotations()
    for fingerprint in (log.authority.fingerprint, *(one.old.fingerprint for one in turned)):
        _checked_head(log, fingerprint)
    _check_successors(log, turned, named=False)


def _checked_head(log: SeenLog, fingerprint: str) -> tuple[Head, Head | None]:
    """The head now, and the one that was seen last."""
    # What was seen is read first: else a later head, remembered by another program meanwhile, would look like a
    # rollback.
    last = last_head(fingerprint)
    head = log.head()
    if last is not None and head.seq < last.seq:
        raise RegistryError(
            f"{log.called} ends at log entry {head.seq}, but entry {last.seq} of it was seen before: it was rolled "
            "back to an earlier state; get its newest copy from those who run it (if they restored it on purpose, "
            f"`moireid registry forget {fingerprint}` accepts it)",
            code="rolled_back",
            head=str(head),
            seen=str(last),
        )
    if last is not None and log.hash_at(last.seq) != last.hash:
        raise RegistryError(
            f"{log.called} holds another log entry {last.seq} than was seen before: it was forked, and something was "
            "written in the place of what had been signed; ask those who run it, and look with "
            "`moireid registry audit`",
            code="forked",
            head=str(head),
            seen=str(last),
        )
    return head, last


def _check_authority(log: SeenLog, trust: str | None, turned: Sequence[Rotation]) -> str | None:
    """The earlier key that is trusted or was seen; None if that is the present key, or nothing is known."""
    fingerprint = log.authority.fingerprint
    wanted = authority_at(log.place) if trust is None else as_fingerprint(trust)
    if wanted is None or wanted == fingerprint:
        return None
    if wanted in [one.old.fingerprint for one in turned]:
        return wanted
    if trust is not None:
        reason, remedy = "the one to be trusted", "get it from those who run it, or ask them for their fingerprint"
    else:
        reason, remedy = "the one seen here before", f"if its makers confirm the new key, add --trust {fingerprint}"
    raise RegistryError(
        f"{log.called} is signed by authority {fingerprint}, and {reason} is {wanted}: its key was replaced; {remedy}",
        code="key_replaced",
        fingerprint=fingerprint,
        trusted=wanted,
    )


def _check_successors(log: SeenLog, turned: Sequence[Rotation], *, named: bool) -> None:
    """Compare its keys with the changes that were seen.  A key that was given up counts no more: a thief may have it.

    Parameters: named: the user names this very authority; of two changes of one earlier key, theirs is then the valid
        one.
    Raises: RegistryError if its key was given up, or an earlier one was given up for another key.
    """
    fingerprint = log.authority.fingerprint
    after = successor_of(fingerprint)
    if after is not None:
        raise RegistryError(
            f"{log.called} is signed by authority {fingerprint}, whose key was given up for {after.fingerprint} by log "
            f"entry {after.seq}, as was seen before; get its newest copy from those who run it (if they say that this "
            f"change was not theirs, `moireid registry forget {fingerprint}` accepts the key again)",
            code="key_given_up",
            fingerprint=fingerprint,
            successor=after.fingerprint,
        )
    for one in () if named else turned:
        after = successor_of(one.old.fingerprint)
        if after is not None and after.fingerprint != one.new.fingerprint:
            raise RegistryError(
                f"{log.called} gives up key {one.old.fingerprint} for {one.new.fingerprint}, and it was seen before to "
                f"be given up for {after.fingerprint}: one of the two changes is a thief's; ask those who run it for "
                f"their fingerprint, and if it is {fingerprint}, add --trust {fingerprint}",
                code="two_successors",
                fingerprint=fingerprint,
                successor=after.fingerprint,
            )
