"""A bundle that the user fetched: its checks, and the badge that a claim means.

1. Its signature, over every byte.
2. Its authority: the trusted one, or the one seen in this file before.
3. Its expiry, and its head: not older than the last one seen of that authority.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from os import cpu_count
from pathlib import Path

from moireid.asbuilt import DatedFigures, as_built_from_json
from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError
from moireid.provenance import BadgeHolder, Provenance
from moireid.question import Question
from moireid.registry.bundle.bundle_file import BundlePerson, read_bundle_file
from moireid.registry.checkpoints.checkpoint import checkpoint_from
from moireid.registry.checkpoints.cosignature import signers
from moireid.registry.checkpoints.note import VerifierKey
from moireid.registry.log import Head
from moireid.registry.look_alikes import folded_skeleton, skeleton
from moireid.registry.merkle import Tree
from moireid.registry.rollback import Watch

#: At most this many people whose names look alike are named.
MOST_ALIKE = 3
#: An identity in hex digits, as a claim.
_ID = re.compile(r"[0-9a-f]{6}|[0-9a-f]{16}|[0-9a-f]{32}")


class Bundle:
    """An open bundle; a context manager that gives its memory back.

    Parameters
    ----------
    path : Path or str
        What `Registry.publish` wrote.
    trust : str, optional
        The fingerprint of the one authority that counts; None for the one that was seen in this file first.

    Attributes
    ----------
    standing : Standing
        Authority, head and expiry.

    Raises
    ------
    RegistryError
        If it is no bundle, was changed, has expired, is another authority's, or is older than one that was seen.
    SpecError
        If `trust` is no fingerprint.
    """

    def __init__(self, path: Path | str, trust: str | None = None) -> None:
        self.path = Path(path)
        expires, self.authority, self._content = read_bundle_file(self.path)
        source = f"of bundle {path}"
        self._checkpoint = checkpoint_from(self._content.checkpoint, f"the text {source}")
        self._checkpoint.check(self.authority, source)
        #: Of ids that were tried on every seal.
        self._holders: dict[str, BundlePerson | None] = {}
        leaves = self._content.leaves
        if Head.over(Tree(leaves)) != self._checkpoint.head:
            raise RegistryError(
                f"bundle {path} holds a checkpoint of another log than its own, so its witnesses say nothing of it; "
                "fetch a newer one",
                code="forked",
            )
        self.standing = Watch(f"bundle {path}", f"bundle:{self.path.absolute()}").standing(
            self.authority.fingerprint, leaves, self._checkpoint.head, trust, expires
        )

    def __enter__(self) -> Bundle:
        return self

    def __exit__(self, *_: object) -> None:
        del self._content

    def claimed(self, claim: str) -> Question:
        """Look up the badge that a claim means.

        Parameters
        ----------
        claim : str
            A name, matched exactly after Unicode NFC, or an id in hex digits, which is tried on every seal.

        Returns
        -------
        Question
            A specimen of its layout with the person's name, the seal of its identity, and why it does not count.

        Raises
        ------
        RegistryError
            If it means no one, or several people.
        """
        name = unicodedata.normalize("NFC", claim)
        found = [one for one in self._content.people if one.name == name] or self._of_id(claim.lower())
        if len(found) > 1:
            raise RegistryError(
                f"{len(found)} people are named {name[:80]!r}, and a bundle keeps their ids sealed; claim the id that "
                "the person or the registry gave you",
                claim=claim,
                ids=[],
            )
        if not found:
            alike = self._alike(name)
            looks = f"but it looks like {' and '.join(alike)}, whose name is written in other letters or case"
            raise RegistryError(
                f"no one named {name[:80]!r} is in bundle {self.path} of {self.standing.head.split(':')[0]} log "
                f"entries, and no one there has such an id; fetch a newer one, or look at the spelling"
                f"{'; ' + looks if alike else ''}",
                claim=claim,
                ids=[],
                alike=alike,
            )
        return self._of(found[0])

    def holder_of(self, badge_id: object) -> BadgeHolder | None:
        """Look up the holder of a badge that was read in a film, by trying its identity on every seal.

        Parameters
        ----------
        badge_id : object
            Hex digits, or any other value that the process which reads untrusted films returns instead.

        Returns
        -------
        BadgeHolder or None
            None if it is no identity, or no one in the bundle holds such a badge.
        """
        if not isinstance(badge_id, str):
            return None
        if badge_id not in self._holders:
            found = self._of_id(badge_id)[:1]
            self._holders[badge_id] = found[0] if found else None
        person = self._holders[badge_id]
        return None if person is None else BadgeHolder(person.name, person.revoked, person.line)

    def require_witnesses(self, witnesses: Sequence[VerifierKey]) -> None:
        """Rely on the bundle only if witnesses have seen the log that it is of.

        Parameters
        ----------
        witnesses : sequence of VerifierKey
            All of them must have signed the bundle's checkpoint.

        Raises
        ------
        RegistryError
            If one did not.

        Notes
        -----
        Witnesses see the log, and not who is in the bundle: for that its authority alone vouches.
        """
        signers(witnesses, self._checkpoint.note, f"of bundle {self.path}")

    def layouts(self) -> list[Badge]:
        """List a badge without a person for each layout, which is enough to read any badge of the bundle.

        Returns
        -------
        list of Badge
            In the bundle's order.
        """
        source = f"a layout of bundle {self.path}"
        return [badge_from_json(text, source=source) for text in self._content.layouts]

    def _of(self, person: BundlePerson) -> Question:
        badge = badge_from_json(self._content.layouts[person.layout], source=f"a layout of bundle {self.path}")
        sets = [DatedFigures(as_built_from_json(figures), at) for figures, at in person.figures]
        provenance = Provenance("bundle", alike=self._alike(person.name), standing=self.standing)
        known = Question(
            replace(badge, name=person.name), seal=person.seal, barred=person.revoked, provenance=provenance
        )
        return with_figures(known, sets)

    def _of_id(self, badge_id: str) -> list[BundlePerson]:
        if not _ID.fullmatch(badge_id):
            return []
        people = self._content.people
        with ThreadPoolExecutor(cpu_count()) as pool:
            opens = pool.map(lambda person: person.seal.holds(badge_id), people, chunksize=64)
            return [person for person, right in zip(people, opens, strict=True) if right]

    def _alike(self, name: str) -> tuple[str, ...]:
        seen, plain = skeleton(name), folded_skeleton(name)
        found = [one.name for one in self._content.people if one.skeleton == seen or one.folded == plain]
        return tuple([one for one in found if one != name][:MOST_ALIKE])


def with_figures(question: Question, sets: Sequence[DatedFigures]) -> Question:
    """A question about a badge with all its sets of measured figures, of which the last one is in use."""
    if not sets:
        return question
    *earlier, own = sets
    return replace(question, as_built=own.as_built, as_built_at=own.at, earlier=tuple(earlier))
