"""A log compared with checkpoints that others kept, entry by entry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from moireid.registry.checkpoints.checkpoint import Checkpoint
from moireid.registry.keys import Authority
from moireid.registry.log import Head
from moireid.registry.merkle import Tree
from moireid.registry.record import Fault


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
        self._authority = authority
        self._forked: list[Checkpoint] = []

    def entry(self, tree: Tree) -> None:
        """Look at the tree after another entry."""
        due = [one for one in self._own if one.size == tree.size]
        self._forked += [one for one in due if one.root != tree.root()]

    def findings(self, head: Head | None, size: int) -> Iterator[tuple[Fault, int | None]]:
        """The faults, each with the entry that it is about.

        Parameters: head: the log's end, None if its signature is not valid; size: entries that were looked at.
        """
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
        for one in self._own:
            if one.size <= size:
                continue
            noted = f"the log ends at entry {size}, and the checkpoint of {one.date} names {one.size} entries"
            if head is None:
                yield Fault("log_cut", f"{noted}: its end was cut off"), one.size
            else:
                text = f"{noted}: the registry was rolled back, an earlier state was put back"
                yield Fault("rolled_back", text), one.size
