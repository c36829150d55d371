"""A registry, or a bundle of one, compared with what this user saw of it before.

It is refused if it was put back to an earlier state, if something else was written in the place of what had been
signed, or if another key signs it than the trusted one, or than the one that was seen there first.  A key that was
given up counts no more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from moireid.errors import RegistryError
from moireid.provenance import Standing
from moireid.registry.keys import Authority, as_fingerprint
from moireid.registry.log import Head, Rotation
from moireid.registry.seen import Memory, remember

#: What a refusal's `details["code"]` may be.
CODES = frozenset({"rolled_back", "forked", "key_replaced", "key_given_up", "two_successors"})


@dataclass(frozen=True)
class LogState:
    """The log of a registry or a bundle, as it is compared with what was seen before.

    called: names it in messages; place: identifies it among all that this user opens; head: its last entry; turned: the
    proven changes of the authority's key, oldest first; extends: whether the log up to `head` goes on from an earlier
    head.
    """

    called: str
    place: str
    authority: Authority
    head: Head
    turned: Sequence[Rotation]
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
        If it is signed by another authority or by a key that was given up, was put back to an earlier state, or was
        forked; `details["code"]` is one of `CODES`.
    SpecError
        If `trust` is no fingerprint.

    Notes
    -----
    A user who trusts an earlier key of the authority, or has seen it here, then trusts the present one.
    """
    kept = compared(log, memory, trust)
    return Standing(
        log.authority.fingerprint,
        str(log.head),
        expires,
        new=trust is None and not any(key in memory.heads for key in kept),
        remembered=_is_known(log, memory, kept) or remember(log.place, kept, log.head, log.turned),
    )


def compared(log: LogState, memory: Memory, trust: str | None) -> list[str]:
    """Compare a log with what was seen of it before, as `standing_of`.

    Returns: the fingerprints under which its head is to be remembered, that of its key first.
    """
    own, wanted = log.authority.fingerprint, memory.authority if trust is None else as_fingerprint(trust)
    named = trust is not None and wanted == own
    earlier = [one.old.fingerprint for one in log.turned]
    _check_authority(log, wanted, earlier, pinned=trust is not None)
    _check_extends(log, memory.heads.get(own), own)
    check_successors(log, memory, named=named)
    # A user who names the present key of two changes of one earlier key may have seen the other log under that key.
    for key in () if named else earlier:
        _check_extends(log, memory.heads.get(key), own)
    # Else a user who still trusts an earlier key would not notice a return to a state before the change.
    return [own, *(key for key in earlier if key in memory.heads or key == wanted)]


def _is_known(log: LogState, memory: Memory, keys: Sequence[str]) -> bool:
    """Whether all that is to be remembered of a log is in the memory."""
    return (
        memory.authority == keys[0]
        and all(memory.heads.get(key) == log.head for key in keys)
        and all(memory.successors.get(one.old.fingerprint) == one.new.fingerprint for one in log.turned)
    )


def _check_extends(log: LogState, last: Head | None, fingerprint: str) -> None:
    """Raise RegistryError unless the log goes on from the head that was seen last."""
    head = log.head
    if last is not None and head.seq < last.seq:
        raise log.refusal(
            "rolled_back",
            f"ends at log entry {head.seq}, but entry {last.seq} of it was seen before: it was rolled back to an "
            f"earlier state, and lacks {last.seq - head.seq} of {last.seq} entries",
            "get its newest copy from those who run it (if they restored it on purpose, `moireid registry forget "
            f"{fingerprint}` accepts it)",
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


def _check_authority(log: LogState, wanted: str | None, earlier: Sequence[str], *, pinned: bool) -> None:
    """Raise RegistryError unless the log's key, or an earlier one, is the wanted one, or none is wanted.

    Parameters: pinned: the user names it; else it is the one that was seen at this place.
    """
    fingerprint = log.authority.fingerprint
    if wanted is None or wanted == fingerprint or wanted in earlier:
        return
    if pinned:
        reason, remedy = "the one to be trusted", "get it from those who run it, or ask them for their fingerprint"
    else:
        reason = "the one seen here before"
        remedy = (
            f"if its makers confirm the new key, add --trust {fingerprint} to `moireid verify`, or give `moireid "
            f"registry forget {wanted}`"
        )
    raise log.refusal(
        "key_replaced",
        f"is signed by authority {fingerprint}, and {reason} is {wanted}: its key was replaced",
        remedy,
        fingerprint=fingerprint,
        trusted=wanted,
    )


def check_successors(log: LogState, memory: Memory, *, named: bool) -> None:
    """Compare its keys with the changes that were seen.  A key that was given up counts no more: a thief may have it.

    Parameters: named: the user names this very authority; of two changes of one earlier key, theirs is then the valid
        one.
    Raises: RegistryError if its key was given up, or an earlier one was given up for another key.
    """
    fingerprint = log.authority.fingerprint
    after = memory.successors.get(fingerprint)
    if after is not None:
        raise log.refusal(
            "key_given_up",
            f"is signed by authority {fingerprint}, whose key was given up for {after}, as was seen before",
            "get its newest copy from those who run it (if they say that this change was not theirs, `moireid registry "
            f"forget {fingerprint}` accepts the key again)",
            fingerprint=fingerprint,
            successor=after,
        )
    for one in () if named else log.turned:
        after = memory.successors.get(one.old.fingerprint)
        if after is not None and after != one.new.fingerprint:
            raise log.refusal(
                "two_successors",
                f"gives up key {one.old.fingerprint} for {one.new.fingerprint}, and it was seen before to be given up "
                f"for {after}: one of the two changes is a thief's",
                f"ask those who run it for their fingerprint, and if it is {fingerprint}, add --trust {fingerprint} to "
                "`moireid verify`",
                fingerprint=fingerprint,
                successor=after,
            )
