"""A signer that has no key and asks the process that has it; and the checks by which that process accepts a text.

The process signs only the few kinds of things that an authority ever signs, each in its own form.  So a client gets no
signature over an arbitrary text, which another program might believe.  A log entry is sent whole, because its hash
alone would not show whether it gives the log to another key.
"""

from __future__ import annotations

import os
import re
import socket
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Literal

import msgspec

from moireid.errors import RegistryError
from moireid.registry.canonical import sha256_hex
from moireid.registry.keys import ENTRY, NOTE, RECORD, ROOT, SIGNER_VARIABLE, Authority, Signs, key_of, new_key
from moireid.registry.log import ROTATE, ROTATED, LogEntry, entry_text
from moireid.user_settings import expanded

#: Kinds by their names in messages; an entry is the fourth, `LOG_ENTRY`.
DOMAINS = {"record": RECORD, "root": ROOT, "note": NOTE}
LOG_ENTRY = "entry"
NAMES = {domain: name for name, domain in DOMAINS.items()}
#: Longest content, bytes: a record's text holds digests in the place of documents, and a note is shorter.
LONGEST = 65536


class SignerMessage(msgspec.Struct, omit_defaults=True):
    """What is asked of the process.

    do: "make" a key pair (answer: "public", its public key, 64 hex digits); "know", whether the private key of `public`
    is there (answer: "fingerprint"); "sign" a content of some kind, in base64 (answer: "signature", 128 hex digits).
    """

    do: Literal["make", "know", "sign"]
    public: str = ""
    kind: str = ""
    content: bytes = b""


#: First lines of notes (`checkpoints/checkpoint.py`, `bundle/bundle_file.py`), before the authority's fingerprint.
NOTE_ORIGINS = ("moireid/registry/", "moireid/bundle3/")
_ROOT = re.compile(rb"[1-9]\d{0,17}:[0-9a-f]{64}")
_TURN = re.compile(f"{ROTATED}([0-9a-f]{{64}}):([0-9a-f]{{64}})")


def of_kind(kind: object, content: bytes, fingerprint: str) -> bool:
    """Whether the content has the form of its kind, for the authority of that fingerprint."""
    if kind == "root":
        return _ROOT.fullmatch(content) is not None
    if kind == "note":
        first = content.partition(b"\n")[0]
        return first in [f"{origin}{fingerprint}".encode() for origin in NOTE_ORIGINS]
    return kind == "record" and _is_record(content)


def _is_record(content: bytes) -> bool:
    """Whether it is the text of a record, as `Record.signed_text` writes it."""
    try:
        fields = msgspec.json.decode(content, type=dict[str, object])
    except (ValueError, RecursionError):
        return False
    return {"badge_json_sha256", "id", "issued_at", "layout_key", "name"} <= set(fields)


def entry_of(content: bytes) -> LogEntry | None:
    """The log entry whose hashed text (`log.entry_text`) this is; None if it is none."""
    try:
        entry = msgspec.json.decode(content.partition(b"\n")[2], type=LogEntry)
    except (ValueError, RecursionError):
        return None
    # Only the canonical spelling is accepted: what is checked here must be what others read.
    if entry_text(msgspec.structs.asdict(entry)) != content:
        return None
    return entry if (entry.action == ROTATE) is entry.subject.startswith(ROTATED) else None


def turn_of(entry: LogEntry) -> tuple[str, str] | None:
    """The public keys, old and new, of an entry that changes the key; None if its subject has another form."""
    found = _TURN.fullmatch(entry.subject)
    return None if found is None else (found[1], found[2])


#: How long the process may take to answer, seconds: it signs in less than a millisecond.
WAIT_S = 30.0


class AskingSigner:
    """Signs in an authority's name by asking; safe to use from any thread.

    Parameters: path: of the socket.
    Raises: RegistryError if no process answers there, or it has no such key.
    """

    def __init__(self, path: str, authority: Authority) -> None:
        self._path, self.authority = path, authority
        _answer(path, SignerMessage("know", authority.public_hex))

    def sign(self, domain: bytes, content: bytes) -> str:
        """The signature over `content` in `domain`, 128 hex digits.

        Raises: RegistryError if the process has ended, or refuses.
        """
        return self._signature(NAMES[domain], content, domain, content)

    def sign_entry(self, text: bytes) -> str:
        """The signature over a log entry, given its hashed text.  Raises: RegistryError as `sign`."""
        return self._signature(LOG_ENTRY, text, ENTRY, sha256_hex(text).encode())

    def _signature(self, kind: str, content: bytes, domain: bytes, signed: bytes) -> str:
        """Parameters: content: what the process gets; signed: what it signs in `domain`."""
        asked = SignerMessage("sign", self.authority.public_hex, kind, content)
        signature = _answer(self._path, asked).get("signature")
        # An invalid signature would make the registry unsound, and no one would know since when.
        if not self.authority.signed(domain, signed, signature):
            raise RegistryError(f"the signer at {self._path} gave a signature that does not hold; start it anew")
        return str(signature)


def load_signer(authority: Authority, shown: str) -> Signs:
    """The signer of an authority: the process that MOIREID_SIGNER names, or the key's file.

    Raises: RegistryError if that one does not have the key; `shown` names the registry in its message.
    """
    path = signer_address()
    try:
        return key_of(authority) if path is None else AskingSigner(path, authority)
    except RegistryError as error:
        details = {"fingerprint": authority.fingerprint} | error.details
        raise RegistryError(f"registry {shown} can only be read here: {error}", **details) from error


def make_key() -> tuple[Signs, Path | None]:
    """A new key pair, made in the keys folder or by the signer process; and its file, None if the process has it.

    Raises: RegistryError if that is not possible.
    """
    path = signer_address()
    if path is None:
        return new_key()
    return AskingSigner(path, Authority(_answer(path, SignerMessage("make"))["public"])), None


def signer_address() -> str | None:
    """The socket that MOIREID_SIGNER names; None if keys are read from files."""
    given = os.environ.get(SIGNER_VARIABLE)
    return str(expanded(given).absolute()) if given else None


def _answer(path: str, message: SignerMessage) -> dict[str, str]:
    try:
        with _connected(path) as line:
            line.send_bytes(msgspec.json.encode(message))
            if not line.poll(WAIT_S):
                raise OSError(0, "no answer")
            answer = msgspec.json.decode(line.recv_bytes(LONGEST), type=dict[str, str])
    except (OSError, EOFError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it ended, or said what cannot be read"
        raise RegistryError(
            f"the signer at {path} does not answer ({reason}); start `moireid registry signer --socket {path}`, or "
            f"unset {SIGNER_VARIABLE} to use a key on this machine"
        ) from error
    if "refused" in answer:
        raise RegistryError(f"the signer at {path} refuses: {answer['refused'][:500]}")
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
