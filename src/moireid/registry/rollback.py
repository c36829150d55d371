"""A registry, or a bundle of one, compared with an earlier state that someone knows: this user, or witnesses.

It is refused if it was put back to an earlier state, if something else was written in the place of what had been
signed, or if another key signs it than the trusted one, or than the one that was seen there first.
"""

from __future__ import annotations

from collections.abc import Sequence

from moireid.errors import RegistryError
from moireid.provenance import Standing
from moireid.registry.keys import as_fingerprint
from moireid.registry.log import Head
from moireid.registry.merkle import Tree
from moireid.registry.seen import recall, remember

#: What a refusal's `details["code"]` may be.
CODES = frozenset({"rolled_back", "forked", "key_replaced"})


def refusal(code: str, called: str, what: str, remedy: str) -> RegistryError:
    """The error for what is wrong with a log; its `details["finding"]` is the sentence without name and remedy."""
    return RegistryError(f"{called} {what}; {remedy}", code=code, finding=f"the registry {what}")


def check_begins(called: str, leaves: Sequence[bytes], known: Head, whose: str, more: str = "") -> None:
    """Check that a log goes on from an earlier state that is known.

    Parameters: called: names the log in messages; leaves: of its entries, compared with its signed head; known: that
        state; whose: who knows it; more: a second remedy.
    Raises: RegistryError if it does not, with code "rolled_back" or "forked".
    """
    if len(leaves) < known.seq:
        what = (
            f"ends at log entry {len(leaves)}, but entry {known.seq} is in {whose}: it was rolled back to an earlier "
            f"state, and lacks {known.seq - len(leaves)} of {known.seq} entries"
        )
        raise refusal("rolled_back", called, what, f"get its newest copy from those who run it{more}")
    if Head.over(Tree(leaves[: known.seq])) != known:
        what = (
            f"holds other log entries up to {known.seq} than {whose}: it was forked, and something was written in the "
            "place of what had been signed"
        )
        raise refusal("forked", called, what, "ask those who run it, and look with `moireid registry audit`")


class Watch:
    """What the user saw of a registry or a bundle, with which its log is compared.

    It is made before the log is read: else a later head, remembered by another program meanwhile, would look like a
    rollback.
    Parameters: called: names it in messages; place: identifies it among all that this user opens.
    """

    def __init__(self, called: str, place: str) -> None:
        self.called, self.place = called, place
        self._authority, self._heads = recall(place)

    def last(self, fingerprint: str) -> Head | None:
        """The head of an authority's log that was seen last; None if none was."""
        return self._heads.get(fingerprint)

    def standing(
        self, fingerprint: str, leaves: Sequence[bytes], head: Head, trust: str | None, expires: str | None = None
    ) -> Standing:
        """Compare a log with what was seen of it before, and remember its present state.

        Parameters
        ----------
        fingerprint, leaves, head, trust
            As `compare`.
        expires : str, optional
            Until when a bundle counts.

        Returns
        -------
        Standing
            Its authority and head.

        Raises
        ------
        RegistryError, SpecError
            As `compare`.
        """
        self.compare(fingerprint, leaves, head, trust)
        known = self._authority == fingerprint and self._heads.get(fingerprint) == head
        return Standing(
            fingerprint,
            str(head),
            expires,
            new=trust is None and fingerprint not in self._heads,
            remembered=known or remember(self.place, fingerprint, head),
        )

    def compare(self, fingerprint: str, leaves: Sequence[bytes], head: Head, trust: str | None) -> None:
        """Compare a log with what was seen of it before.

        Parameters
        ----------
        fingerprint : str
            Of its authority.
        leaves, head : sequence of bytes, Head
            Of all its entries, and the head over them.
        trust : str or None
            The fingerprint of the one authority that counts; None for the one that was seen at this place first.

        Raises
        ------
        RegistryError
            If it is signed by another authority, was put back to an earlier state, or was forked; `details["code"]` is
            one of `CODES`.
        SpecError
            If `trust` is no fingerprint.
        """
        wanted = self._authority if trust is None else as_fingerprint(trust)
        if wanted not in (None, fingerprint):
            whose, remedy = "the one to be trusted", "get it from those who run it, or ask them for their fingerprint"
            if trust is None:
                whose = "the one seen here before"
                remedy = (
                    f"if its makers confirm the new key, verify with trust={fingerprint}, or give `moireid registry "
                    f"forget {wanted}`"
                )
            what = f"is signed by authority {fingerprint}, and {whose} is {wanted}: its key was replaced"
            raise refusal("key_replaced", self.called, what, remedy)
        last = self.last(fingerprint)
        if last is not None and last != head:
            more = f" (if they restored it on purpose, `moireid registry forget {fingerprint}` accepts it)"
            check_begins(self.called, leaves, last, "what was seen of it before", more)
