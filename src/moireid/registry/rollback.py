"""A registry, or a bundle of one, compared with what this user saw of it before.

It is refused if it was put back to an earlier state, if something else was written in the place of what had been
signed, or if another key signs it than the trusted one, or than the one that was seen there first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from moireid.errors import RegistryError
from moireid.provenance import Standing
from moireid.registry.keys import as_fingerprint
from moireid.registry.log import Head
from moireid.registry.seen import Memory, remember

#: What a refusal's `details["code"]` may be.
CODES = frozenset({"rolled_back", "forked", "key_replaced"})


@dataclass(frozen=True)
class LogState:
    """The log of a registry or a bundle, as it is compared with what was seen before.

    called: names it in messages; place: identifies it among all that this user opens; fingerprint: of its authority;
    head: its last entry; extends: whether the log up to `head` goes on from an earlier head.
    """

    called: str
    place: str
    fingerprint: str
    head: Head
    extends: Callable[[Head], bool]

    def refusal(self, code: str, what: str, remedy: str, **details: object) -> RegistryError:
        """The error for what is wrong with it; its `details["finding"]` is the sentence without name and remedy."""
        return RegistryError(f"{self.called} {what}; {remedy}", code=code, finding=f"the registry {what}", **details)


def standing_of(log: LogState, memory: Memory, trust: str | None = None, expires: str | None = None) -> Standing:
    """Compare a log with what was seen of it before, and remember its present state.

    Parameters
    ----------
    log : LogState
        Its present state.
    memory : Memory
        What was seen before.  It is read before the log is: else a later head, remembered by another program meanwhile,
        would look like a rollback.
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
        If it is signed by another authority, was put back to an earlier state, or was forked; `details["code"]` is one
        of `CODES`.
    SpecError
        If `trust` is no fingerprint.
    """
    compared(log, memory, trust)
    own = log.fingerprint
    authority, heads = memory
    known = authority == own and heads.get(own) == log.head
    return Standing(
        own,
        str(log.head),
        expires,
        new=trust is None and own not in heads,
        remembered=known or remember(log.place, own, log.head),
    )


def compared(log: LogState, memory: Memory, trust: str | None) -> None:
    """Compare a log with what was seen of it before.  Raises: RegistryError, SpecError as `standing_of`."""
    wanted = memory[0] if trust is None else as_fingerprint(trust)
    if wanted not in (None, log.fingerprint):
        raise _other_key(log, str(wanted), pinned=trust is not None)
    _check_extends(log, memory[1].get(log.fingerprint))


def _check_extends(log: LogState, last: Head | None) -> None:
    """Raise RegistryError unless the log goes on from the head that was seen last."""
    head = log.head
    if last is not None and head.seq < last.seq:
        raise log.refusal(
            "rolled_back",
            f"ends at log entry {head.seq}, but entry {last.seq} of it was seen before: it was rolled back to an "
            f"earlier state, and lacks {last.seq - head.seq} of {last.seq} entries",
            "get its newest copy from those who run it (if they restored it on purpose, `moireid registry forget "
            f"{log.fingerprint}` accepts it)",
            head=str(head),
            seen=str(last),
        )
    if last is not None and not log.extends(last):
        raise log.refusal(
            "forked",
            f"holds another log entry {last.seq} than was seen before: it was forked, and something was written in the "
            "place of what had been signed",
            "ask those who run it, and look with `moireid registry audit`",
            head=str(head),
            seen=str(last),
        )


def _other_key(log: LogState, wanted: str, *, pinned: bool) -> RegistryError:
    """The error where the log's key is not the wanted one, which the user names, or which was seen at this place."""
    if pinned:
        reason, remedy = "the one to be trusted", "get it from those who run it, or ask them for their fingerprint"
    else:
        reason = "the one seen here before"
        remedy = (
            f"if its makers confirm the new key, verify with trust={log.fingerprint}, or give `moireid registry "
            f"forget {wanted}`"
        )
    return log.refusal(
        "key_replaced",
        f"is signed by authority {log.fingerprint}, and {reason} is {wanted}: its key was replaced",
        remedy,
        fingerprint=log.fingerprint,
        trusted=wanted,
    )
