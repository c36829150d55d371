"""A registry, or a bundle of one, compared with what this user saw of it before.

It is refused if it was put back to an earlier state, if something else was written in the place of what had been
signed, or if another key signs it than the trusted one, or than the one that was seen there first.
"""

from __future__ import annotations

from collections.abc import Callable

from moireid.errors import RegistryError
from moireid.provenance import Standing
from moireid.registry.keys import as_fingerprint
from moireid.registry.log import Head
from moireid.registry.seen import recall, remember

#: What a refusal's `details["code"]` may be.
CODES = frozenset({"rolled_back", "forked", "key_replaced"})


class Watch:
    """What the user saw of a registry or a bundle, with which its log is compared.

    It is made before the log is read: else a later head, remembered by another program meanwhile, would look like a
    rollback.
    Parameters: called: names it in messages; place: identifies it among all that this user opens.
    """

    def __init__(self, called: str, place: str) -> None:
        self.called, self.place = called, place
        self._authority, self._heads = recall(place)

    def standing(
        self,
        fingerprint: str,
        head: Head,
        extends: Callable[[Head], bool],
        trust: str | None = None,
        expires: str | None = None,
    ) -> Standing:
        """Compare a log with what was seen of it before, and remember its present state.

        Parameters
        ----------
        fingerprint, head, extends, trust
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
        self.compare(fingerprint, head, extends, trust)
        known = self._authority == fingerprint and self._heads.get(fingerprint) == head
        return Standing(
            fingerprint,
            str(head),
            expires,
            new=trust is None and fingerprint not in self._heads,
            remembered=known or remember(self.place, fingerprint, head),
        )

    def compare(self, fingerprint: str, head: Head, extends: Callable[[Head], bool], trust: str | None) -> None:
        """Compare a log with what was seen of it before.

        Parameters
        ----------
        fingerprint : str
            Of its authority.
        head : Head
            Its last entry.
        extends : callable
            Whether the log up to `head` goes on from an earlier head.
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
            raise self._other_key(fingerprint, str(wanted), pinned=trust is not None)
        last = self._heads.get(fingerprint)
        if last is not None and head.seq < last.seq:
            raise self._refusal(
                "rolled_back",
                f"ends at log entry {head.seq}, but entry {last.seq} of it was seen before: it was rolled back to an "
                f"earlier state, and lacks {last.seq - head.seq} of {last.seq} entries",
                "get its newest copy from those who run it (if they restored it on purpose, `moireid registry forget "
                f"{fingerprint}` accepts it)",
                head=str(head),
                seen=str(last),
            )
        if last is not None and not extends(last):
            raise self._refusal(
                "forked",
                f"holds another log entry {last.seq} than was seen before: it was forked, and something was written in "
                "the place of what had been signed",
                "ask those who run it, and look with `moireid registry audit`",
                head=str(head),
                seen=str(last),
            )

    def _refusal(self, code: str, what: str, remedy: str, **details: object) -> RegistryError:
        """The error for what is wrong with it; its `details["finding"]` is the sentence without name and remedy."""
        return RegistryError(f"{self.called} {what}; {remedy}", code=code, finding=f"the registry {what}", **details)

    def _other_key(self, fingerprint: str, wanted: str, *, pinned: bool) -> RegistryError:
        """The error for a key that is not the wanted one, which the user names, or which was seen at this place."""
        if pinned:
            reason, remedy = "the one to be trusted", "get it from those who run it, or ask them for their fingerprint"
        else:
            reason = "the one seen here before"
            remedy = (
                f"if its makers confirm the new key, verify with trust={fingerprint}, or give `moireid registry "
                f"forget {wanted}`"
            )
        return self._refusal(
            "key_replaced",
            f"is signed by authority {fingerprint}, and {reason} is {wanted}: its key was replaced",
            remedy,
            fingerprint=fingerprint,
            trusted=wanted,
        )
