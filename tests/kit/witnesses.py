"""A log with a key of its own, which may sign whatever it likes; witnesses' servers, in this process and in another."""

from __future__ import annotations

import base64
import json
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from moireid.registry.checkpoints.note import ED25519, VerifierKey
from moireid.registry.merkle import ReadNodes, all_nodes, consistency_proof, leaf_hash, root_at
from moireid.registry.witness.request import AddRequest
from moireid.registry.witness.server import WitnessServer
from moireid.registry.witness.state import Witness


def leaves_of(count: int, branch: int | None = None, name: str = "") -> list[bytes]:
    """The leaves of a log; from the entry `branch` on they depend on `name`."""
    return [
        leaf_hash(f"{number} {name if branch is not None and number >= branch else ''}".encode())
        for number in range(count)
    ]


def reading(leaves: Sequence[bytes]) -> ReadNodes:
    """The nodes over these leaves, as `merkle` looks them up."""
    nodes = all_nodes(leaves)
    return lambda places: nodes


def root_of(leaves: Sequence[bytes]) -> bytes:
    """The root of these leaves."""
    return root_at(reading(leaves), len(leaves))


class Log:
    """A log that signs any tree that it is given."""

    def __init__(self, origin: str, *, seed: bytes | None = None) -> None:
        self.key = Ed25519PrivateKey.generate() if seed is None else Ed25519PrivateKey.from_private_bytes(seed)
        self.public = VerifierKey(origin, ED25519, self.key.public_key().public_bytes_raw())

    def note(self, leaves: Sequence[bytes], *, extension: str = "") -> str:
        """The checkpoint of these leaves."""
        root = base64.b64encode(root_of(leaves)).decode()
        text = f"{self.public.name}\n{len(leaves)}\n{root}\n{extension}"
        return f"{text}\n{self.public.line(self.key.sign(text.encode()))}"

    def request(self, leaves: Sequence[bytes], old: int, proof: Sequence[bytes] | None = None) -> bytes:
        """The request for these leaves, with the right proof if none is given."""
        if proof is None:
            proof = consistency_proof(reading(leaves), len(leaves), old) if 0 < old <= len(leaves) else []
        return AddRequest(old, proof, self.note(leaves)).to_bytes()


@contextmanager
def serving(witness: Witness) -> Iterator[str]:
    """The address of a witness that answers in this process."""
    with WitnessServer(witness, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        try:
            yield server.address
        finally:
            server.shutdown()


def started(state: Path, name: str, *logs: VerifierKey) -> tuple[subprocess.Popen[str], str, VerifierKey]:
    """A witness's program, its address and its key."""
    words = [word for log in logs for word in ("--log", str(log))]
    words += ["--state", str(state), "--name", name, "--listen", "127.0.0.1:0", "--json"]
    command = [sys.executable, "-c", "from moireid.cli.main import main; main()", "witness", *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    said = json.loads(process.stdout.readline())
    return process, said["address"], VerifierKey.parse(said["key"])
