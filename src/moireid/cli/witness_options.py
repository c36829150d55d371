"""The options by which a reader asks for the signatures of witnesses, who follow a registry's log, on a checkpoint."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.registry import Registry
    from moireid.registry.bundle.held import Bundle
    from moireid.registry.checkpoints.note import VerifierKey

witness_option = click.option(
    "--witness-key",
    "witness_keys",
    metavar="KEY|FILE",
    multiple=True,
    help="The public key of a witness that you trust, NAME+ID+KEY, or a file of such lines. Then all of them must have "
    "signed the checkpoint, in the last 7 days. May be given several times.",
)
checkpoint_option = click.option(
    "--checkpoint",
    type=click.Path(path_type=Path),
    help="The registry's newest checkpoint, which the witnesses of --witness-key signed; a bundle holds its own.",
)


@dataclass(frozen=True)
class WitnessCheck:
    """The witnesses that must have signed a checkpoint, and its file; None for the one that a bundle holds."""

    source: Path | None
    witnesses: tuple[VerifierKey, ...]

    def require(self, held: Registry | Bundle) -> None:
        """Rely only on what they have seen of a registry.  Raises: RegistryError if that is not possible."""
        from moireid.registry.bundle.held import Bundle
        from moireid.registry.checkpoints.checkpoint import read_checkpoint

        if isinstance(held, Bundle):
            held.require_witnesses(self.witnesses)
        elif self.source is not None:
            held.require_witnesses(self.witnesses, read_checkpoint(self.source))


def witness_check(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options, and hand it their meaning as `witness_check`; a bundle holds its checkpoint."""

    @functools.wraps(command)
    def wrapped(
        *args: Any,
        checkpoint: Path | None,
        witness_keys: tuple[str, ...],
        **given: Any,
    ) -> Any:
        if not witness_keys:
            if checkpoint is not None:
                raise SpecError("--checkpoint needs the keys of the witnesses; add --witness-key")
            return command(*args, witness_check=None, **given)
        from moireid.registry.checkpoints.cosignature import witness_keys as read_keys

        bundled = given.get("bundle_path") is not None
        if checkpoint is None and not bundled:
            raise SpecError("--witness-key needs what the witnesses signed; add --checkpoint FILE")
        if checkpoint is not None and bundled:
            raise SpecError("a bundle holds its own checkpoint; leave one of --bundle and --checkpoint out")
        return command(*args, witness_check=WitnessCheck(checkpoint, read_keys(witness_keys)), **given)

    return checkpoint_option(witness_option(wrapped))
