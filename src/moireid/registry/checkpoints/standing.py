"""A registry, or a bundle of it, held against what was seen last and against what the user trusts."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from moireid.errors import RegistryError, SpecError
from moireid.provenance import Standing
from moireid.registry.checkpoints.checkpoint import Checkpoint, signed_state
from moireid.registry.checkpoints.seen import authority_at, last_head, remember, successor_of
from moireid.registry.keys import FINGERPRINT_DIGITS
from moireid.registry.ledger import Ledger
from moireid.registry.log import Head, Rotation


def as_fingerprint(text: str) -> str:
    """A fingerprint as people write it: any case, with blanks or colons.  Raises: SpecError where it is none."""
    digits = re.sub(r"[\s:]", "", text).lower()
    if not re.fullmatch(f"[0-9a-f]{{{FINGERPRINT_DIGITS}}}", digits):
        raise SpecError(
            f"fingerprint {text[:80]!r} is none; give the {FINGERPRINT_DIGITS} hex digits that `moireid registry init` "
            "prints for those who run the registry"
        )
    return digits


def standing_of(ledger: Ledger, trust: str | None = None) -> Standing:
    """Hold a registry against what was seen of it, and remember it as it is now.

    Parameters
    ----------
    ledger : Ledger
        An open registry's.
    trust : str, optional
        The fingerprint of the one authority that counts; None for the one that was seen at this place first.

    Returns
    -------
    Standing
        Its authority and head.

    Raises
    ------
    RegistryError
        Where it is signed by another authority or by a key that was given up, was put back to an earlier state, or was
        forked; `details["code"]` is "key_replaced", "key_given_up", "two_successors", "rolled_back" or "forked".  Also
        where its head is not as signed.
    SpecError
        Where `trust` is no fingerprint.
    """
    what = f"registry {ledger.shown}"
    own = ledger.authority.fingerprint
    return hold(what, ledger.place, own, ledger.head, ledger.hash_at, trust, turned=ledger.rotations())


def hold(
    what: str,
    place: str,
    fingerprint: str,
    head_now: Callable[[], Head],
    hash_at: Callable[[int], str | None],
    trust: str | None,
    expires: str | None = None,
    *,
    turned: Sequence[Rotation],
) -> Standing:
    """As `standing_of`, for whatever has a head.

    Parameters: hash_at: gives the hash of an earlier entry; what: names it; turned: the changes of its authority's key,
        proven.  Who trusts one of the earlier keys, or has seen it here, follows to the present one.
    """
    followed = _check_authority(what, place, fingerprint, trust, [one.old.fingerprint for one in turned])
    head, last = _checked_head(what, fingerprint, head_now, hash_at)
    _check_successors(what, fingerprint, turned, named=trust is not None and as_fingerprint(trust) == fingerprint)
    if followed is not None:
        # What was seen under the earlier key must still be there.
        _, last = _checked_head(what, followed, lambda: head, hash_at)
        # Else who goes on trusting that key would not notice a step back to before the change.
        remember(place, followed, head)
    kept = remember(place, fingerprint, head, turned)
    return Standing(fingerprint, str(head), expires, new=last is None and trust is None, remembered=kept)


def check_head(ledger: Ledger) -> None:
    """Raise RegistryError if the log was further before; who writes to an earlier state would fork it."""
    what, own, turned = f"registry {ledger.shown}", ledger.authority.fingerprint, ledger.rotations()
    for fingerprint in (own, *(one.old.fingerprint for one in turned)):
        _checked_head(what, fingerprint, ledger.head, ledger.hash_at)
    _check_successors(what, own, turned, named=False)


def _checked_head(
    what: str, fingerprint: str, head_now: Callable[[], Head], hash_at: Callable[[int], str | None]
) -> tuple[Head, Head | None]:
    """The head now, and the one that was seen last."""
    # What was seen is read first: what another program remembers meanwhile would else look like a step back.
    last = last_head(fingerprint)
    head = head_now()
    if last is not None and head.seq < last.seq:
        raise RegistryError(
            f"{what} ends at log entry {head.seq}, but entry {last.seq} of it was seen before: it was rolled back to "
            "an earlier state; get its newest copy from those who run it (if they restored it on purpose, "
            f"`moireid registry forget {fingerprint}` accepts it)",
            code="rolled_back",
            head=str(head),
            seen=str(last),
        )
    if last is not None and hash_at(last.seq) != last.hash:
        raise RegistryError(
            f"{what} holds another log entry {last.seq} than was seen before: it was forked, and something was written "
            "in the place of what had been signed; ask those who run it, and look with `moireid registry audit`",
            code="forked",
            head=str(head),
            seen=str(last),
        )
    return head, last


def _check_authority(what: str, place: str, fingerprint: str, trust: str | None, former: Sequence[str]) -> str | None:
    """The earlier key that is trusted, or was seen; None where the present one is, or nothing is known."""
    wanted = authority_at(place) if trust is None else as_fingerprint(trust)
    if wanted is None or wanted == fingerprint:
        return None
    if wanted in former:
        return wanted
    if trust is not None:
        reason, remedy = "the one to be trusted", "get it from those who run it, or ask them for their fingerprint"
    else:
        reason, remedy = "the one seen here before", f"if its makers confirm the new key, add --trust {fingerprint}"
    raise RegistryError(
        f"{what} is signed by authority {fingerprint}, and {reason} is {wanted}: its key was replaced; {remedy}",
        code="key_replaced",
        fingerprint=fingerprint,
        trusted=wanted,
    )


def _check_successors(what: str, fingerprint: str, turned: Sequence[Rotation], *, named: bool) -> None:
    """Hold its keys against the changes that were seen.  A key that was given up counts no more: a thief may have it.

    Parameters: named: the user names this very authority; of two changes of one earlier key, theirs is then the one.
    Raises: RegistryError where its key was given up, or an earlier one was given up for another key.
    """
    after = successor_of(fingerprint)
    if after is not None:
        raise RegistryError(
            f"{what} is signed by authority {fingerprint}, whose key was given up for {after.fingerprint} by log entry "
            f"{after.seq}, as was seen before: get its newest copy from those who run it (if they say that this change "
            f"was not theirs, `moireid registry forget {fingerprint}` accepts the key again)",
            code="key_given_up",
            fingerprint=fingerprint,
            successor=after.fingerprint,
        )
    for one in () if named else turned:
        after = successor_of(one.old.fingerprint)
        if after is not None and after.fingerprint != one.new.fingerprint:
            raise RegistryError(
                f"{what} gives up key {one.old.fingerprint} for {one.new.fingerprint}, and it was seen before to be "
                f"given up for {after.fingerprint}: one of the two changes is a thief's; ask those who run it for "
                f"their fingerprint, and if it is {fingerprint}, add --trust {fingerprint}",
                code="two_successors",
                fingerprint=fingerprint,
                successor=after.fingerprint,
            )


def checkpoint_of(ledger: Ledger, older: Sequence[Checkpoint]) -> tuple[Checkpoint, list[tuple[int, list[bytes]]]]:
    """What `Registry.checkpoint` does."""
    # First the key: only where it lies, this authority is surely the right one here.
    ledger.signer()
    standing_of(ledger, ledger.authority.fingerprint)
    return signed_state(ledger, older)
