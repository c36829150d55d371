"""A signer that has no key: it asks the process that has it."""

from __future__ import annotations

import base64
import json
import os
import socket
import threading
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from moireid.errors import RegistryError
from moireid.registry.canonical import sha256_hex
from moireid.registry.keys import ENTRY, SIGNER_VARIABLE, Authority, Signs, key_of, new_key
from moireid.registry.signing.kinds import LOG_ENTRY, LONGEST, NAMES

#: How long the process may take to answer, seconds: it signs in less than a millisecond.
WAIT_S = 30.0


class AskingSigner:
    """Signs in an authority's name by asking; safe to use from any thread.

    Parameters: path: of the socket.
    Raises: RegistryError where nobody answers there, or the process has no such key.
    """

    def __init__(self, path: str, authority: Authority) -> None:
        self._path, self._lock = path, threading.Lock()
        self._line: Connection | None = None
        self.authority = authority
        self._ask({"do": "know", "public": authority.public_hex})

    def sign(self, domain: bytes, content: bytes) -> str:
        """The signature over `content` in `domain`, 128 hex digits.

        Raises: RegistryError where the process has gone, or refuses.
        """
        return self._signature(NAMES[domain], content, domain, content)

    def sign_entry(self, text: bytes) -> str:
        """The signature over a log entry, by its text as it is hashed.  Raises: RegistryError as `sign`."""
        return self._signature(LOG_ENTRY, text, ENTRY, sha256_hex(text).encode())

    def _signature(self, kind: str, told: bytes, domain: bytes, signed: bytes) -> str:
        """Parameters: told: what the process is shown; signed: what it signs in `domain`."""
        asked = {"do": "sign", "public": self.authority.public_hex, "kind": kind}
        signature = self._ask(asked | {"content": base64.b64encode(told).decode()}).get("signature")
        # A signature that does not hold would make the registry unsound, and nobody would know since when.
        if not self.authority.signed(domain, signed, signature):
            raise RegistryError(f"the signer at {self._path} gave a signature that does not hold; start it anew")
        return str(signature)

    def _ask(self, message: dict[str, Any]) -> dict[str, Any]:
        return _answer(self._path, message, self._told)

    def _told(self, message: bytes) -> bytes:
        """One answer, over a connection that is kept; by a new one where the process was started anew."""
        with self._lock:
            if self._line is not None:
                try:
                    return _once(self._line, message)
                except (OSError, EOFError):
                    self._line = None
            self._line = _connected(self._path)
            return _once(self._line, message)


def load_signer(authority: Authority, shown: str) -> Signs:
    """Who signs for an authority here: the process that MOIREID_SIGNER names, or the key's file.

    Raises: RegistryError where neither has the key; `shown` names the registry in its message.
    """
    path = signer_address()
    try:
        return key_of(authority) if path is None else AskingSigner(path, authority)
    except RegistryError as error:
        details = {"fingerprint": authority.fingerprint} | error.details
        raise RegistryError(f"registry {shown} can only be read here: {error}", **details) from error


def make_key() -> tuple[Signs, Path | None]:
    """A new key pair, made where keys are kept; its file, None where another process has it.

    Raises: RegistryError where that is not possible.
    """
    path = signer_address()
    if path is None:
        return new_key()

    def told(message: bytes) -> bytes:
        return _once(_connected(path), message)

    return AskingSigner(path, Authority(str(_answer(path, {"do": "make"}, told)["public"]))), None


def signer_address() -> str | None:
    """The socket that MOIREID_SIGNER names; None where keys are read from files."""
    given = os.environ.get(SIGNER_VARIABLE)
    return str(Path(given).expanduser().absolute()) if given else None


def _answer(path: str, message: dict[str, Any], told: Any) -> dict[str, Any]:
    try:
        answer = json.loads(told(json.dumps(message).encode()))
    except (OSError, EOFError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it ended, or said what cannot be read"
        raise RegistryError(
            f"the signer at {path} does not answer ({reason}); start `moireid registry signer --socket {path}`, or "
            f"unset {SIGNER_VARIABLE} to use a key on this machine"
        ) from error
    if not isinstance(answer, dict) or "refused" in answer:
        words = answer.get("refused") if isinstance(answer, dict) else "it said what cannot be read"
        raise RegistryError(f"the signer at {path} refuses: {str(words)[:500]}")
    return answer


def _connected(path: str) -> Connection:
    made = socket.socket(socket.AF_UNIX)
    made.settimeout(WAIT_S)
    try:
        made.connect(path)
    except OSError:
        made.close()
        raise
    made.settimeout(None)
    return Connection(made.detach())


def _once(line: Connection, message: bytes) -> bytes:
    line.send_bytes(message)
    if not line.poll(WAIT_S):
        raise OSError(0, "no answer")
    return line.recv_bytes(LONGEST)
