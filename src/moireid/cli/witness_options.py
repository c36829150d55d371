"""The options by which a reader asks for the signatures of witnesses, who follow a registry's log, on a checkpoint."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import FiniteRange
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.registry import Registry
    from moireid.registry.bundle.held import Bundle
    from moireid.registry.checkpoints.checkpoint import Checkpoint
    from moireid.registry.checkpoints.cosignature import Quorum

QUORUM_OPTIONS = (
    click.option(
        "--witness-key",
        "witness_keys",
        metavar="KEY|FILE",
        multiple=True,
        help="The public key of a witness that you trust, NAME+ID+KEY, or a file of such lines. Then "
        "witnesses must have signed the checkpoint. May be given several times.",
    ),
    click.option(
        "--witnesses",
        "witnesses_needed",
        type=click.IntRange(1),
        metavar="K",
        help="So many of these witnesses must have signed, more than half of them.  [default: all]",
    ),
    click.option(
        "--witness-days",
        type=FiniteRange(0.001, 4000),
        default=7.0,
        show_default=True,
        metavar="NUMBER",
        help="So old a signature of a witness may be: so long a revocation could be kept from you.",
    ),
)


def quorum_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options by which witnesses are named."""
    for option in reversed(QUORUM_OPTIONS):
        command = option(command)
    return command


checkpoint_option = click.option(
    "--checkpoint",
    metavar="FILE|URL",
    help="The registry's newest checkpoint, which the witnesses of --witness-key signed; a bundle holds its own.",
)


def quorum_of(
    witness_keys: tuple[str, ...], witnesses_needed: int | None, witness_days: float, needs: str
) -> Quorum | None:
    """The witnesses that must have signed; None if none is named.

    Raises: SpecError if that is not possible; needs: says for what the keys are missing.
    """
    if not witness_keys:
        if witnesses_needed is not None or needs:
            raise SpecError(f"{needs or '--witnesses'} needs the keys of the witnesses; add --witness-key")
        return None
    from moireid.registry.checkpoints.cosignature import Quorum

    return Quorum.of(witness_keys, witnesses_needed, witness_days)


@dataclass(frozen=True)
class WitnessCheck:
    """A checkpoint, and the witnesses that must have signed it; source: None for the one that a bundle holds."""

    source: str | None
    quorum: Quorum

    @cached_property
    def _checkpoint(self) -> Checkpoint:
        """Read once: what is looked up later rests on the same one."""
        return self.newest()

    def newest(self) -> Checkpoint:
        """The checkpoint as it is now.  Raises: RegistryError, SpecError if there is none, or several."""
        from moireid.registry.checkpoints.sources import one_checkpoint_from

        if self.source is None:
            raise SpecError("--witness-key needs what the witnesses signed; add --checkpoint FILE|URL")
        return one_checkpoint_from(self.source)

    def require(self, held: Registry | Bundle) -> None:
        """Rely only on what they have seen of a registry.  Raises: RegistryError if that is not possible."""
        from moireid.registry.bundle.held import Bundle

        if isinstance(held, Bundle):
            held.require_witnesses(self.quorum)
        else:
            held.require_witnesses(self._checkpoint, self.quorum, self.source or "")


def require(check: WitnessCheck | None, held: Registry | Bundle) -> None:
    """As `WitnessCheck.require`; nothing if no witness is asked for."""
    if check is not None:
        check.require(held)


def witness_check(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options, and hand it their meaning as `witness_check`; a bundle holds its checkpoint."""

    @functools.wraps(command)
    def wrapped(
        *args: Any,
        checkpoint: str | None,
        witness_keys: tuple[str, ...],
        witnesses_needed: int | None,
        witness_days: float,
        **given: Any,
    ) -> Any:
        quorum = quorum_of(witness_keys, witnesses_needed, witness_days, "--checkpoint" if checkpoint else "")
        if quorum is None:
            return command(*args, witness_check=None, **given)
        bundled = given.get("bundle_path") is not None
        if checkpoint is None and not bundled:
            raise SpecError("--witness-key needs what the witnesses signed; add --checkpoint FILE|URL")
        if checkpoint is not None and bundled:
            raise SpecError("a bundle holds its own checkpoint; leave one of --bundle and --checkpoint out")
        return command(*args, witness_check=WitnessCheck(checkpoint, quorum), **given)

    return checkpoint_option(quorum_options(wrapped))
