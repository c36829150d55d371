"""witness: a server that signs a registry's checkpoints, so that its readers need not trust it alone."""

from __future__ import annotations

import contextlib
from pathlib import Path

import click

from moireid.cli.common import friendly, json_option, say, show_json
from moireid.errors import SpecError


@click.command("witness")
@click.option(
    "--state",
    "path",
    required=True,
    type=click.Path(path_type=Path, dir_okay=False),
    help="The file with the witness's private key, and what it signed last. It is made if it is absent. Keep no backup "
    "of it: a witness that was put back to an earlier state signs what contradicts what it signed.",
)
@click.option(
    "--name", required=True, help="The witness's name, such as example.org/witness; it stays with the key for ever."
)
@click.option(
    "--log",
    "logs",
    metavar="KEY|FILE",
    multiple=True,
    required=True,
    help="The public key of a log that it follows, as `moireid registry init` shows it for witnesses; or a file of "
    "such lines. May be given several times.",
)
@click.option(
    "--listen",
    metavar="HOST:PORT",
    default="127.0.0.1:8735",
    show_default=True,
    help="Where it listens. Port 0: any that is free.",
)
@json_option
@friendly
def witness_command(path: Path, name: str, logs: tuple[str, ...], listen: str, as_json: bool) -> None:
    """Sign checkpoints of registries, as a witness.

    A witness signs a checkpoint only if the log goes on from all that it signed before. So those who run a registry
    cannot show two logs to two readers, or take a revocation back, unless witnesses help them. Run one for others; it
    learns no names, and needs no film and no registry.

    Give its public key to readers (`--witness-key`), and its address to those who run the registry (`moireid registry
    checkpoint --witness URL`). The protocol is that of C2SP (tlog-witness), so any other log can use it too.

    Stop it with Ctrl-C; it can be ended at any time, and forgets nothing.
    """
    from moireid.registry.checkpoints.cosignature import keys_given
    from moireid.registry.checkpoints.note import ED25519
    from moireid.registry.witness.server import WitnessServer
    from moireid.registry.witness.state import Witness

    host, _, port = listen.rpartition(":")
    if not host or not port.isascii() or not port.isdecimal() or int(port) > 65535:
        raise SpecError(f"{listen[:80]!r} is no place to listen; give HOST:PORT, such as 127.0.0.1:8735")
    witness = Witness(path, name, keys_given(logs, ED25519, "log"))
    with WitnessServer(witness, host.strip("[]"), int(port)) as server:
        if as_json:
            show_json({"name": name, "key": str(witness.public), "address": server.address, "logs": len(logs)})
        say(f"witness {witness.public}")
        say(f"signing checkpoints at {server.address}  (stop it with Ctrl-C)")
        with contextlib.suppress(KeyboardInterrupt):
            server.serve_forever()
