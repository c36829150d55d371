"""The authority's key pair, and how the log names actors.

The key pair is Ed25519.  The public half is in the registry, the private half in a file of its own.  That file is PEM
PKCS #8, readable by its owner alone, named by the public key's fingerprint, in the folder that MOIREID_KEYS names, or
in `keys` of the user's data folder.  Nothing ever writes a private key to a registry, an export or a log.

An actor is the person or account that does something to the registry, as the log names them: an account of this
machine, or the holder of a studio's token.

Convention: every signature covers a domain (a line with the kind of thing signed and its version) and then the content.
So a signed record can never be taken for a signed log entry, nor for one of another version.
"""

from __future__ import annotations

import os
import pwd
import re
from pathlib import Path

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

from moireid.errors import RegistryError, SpecError
from moireid.files import read_regular, whole_file
from moireid.registry.canonical import sha256_hex
from moireid.user_settings import data_folder, expanded

KEYS_VARIABLE = "MOIREID_KEYS"

RECORD = b"moireid registry record 2\n"
ENTRY = b"moireid registry log entry 1\n"
#: Precedes the text of an entry that is hashed.
ENTRY_TEXT = b"moireid registry log entry 3\n"
#: Of heads: the root over all entries.
ROOT = b"moireid registry log head 2\n"
#: Notes (checkpoints, bundles) have a common format, in which nothing precedes the text.  Its first line, such as
#: `moireid/registry/...`, does what a domain does.
NOTE = b""

#: Hex digits of a fingerprint: 128 bits, so that no one can find a second key with the same one.
FINGERPRINT_DIGITS = 32


class Authority:
    """The public half: says whether a signature is the authority's."""

    def __init__(self, public_hex: str) -> None:
        """Raises: ValueError if `public_hex` is not 64 lower-case hex digits of a key."""
        content = bytes.fromhex(public_hex)
        if content.hex() != public_hex:
            raise ValueError("the key is not in lower-case hex digits")
        self._key = Ed25519PublicKey.from_public_bytes(content)
        self.public_hex = public_hex
        self.digest = sha256_hex(content)
        self.fingerprint = self.digest[:FINGERPRINT_DIGITS]

    def signed(self, domain: bytes, content: bytes, signature_hex: object) -> bool:
        """Whether `signature_hex`, 128 lower-case hex digits, is the authority's over `content` in `domain`."""
        if not isinstance(signature_hex, str):
            return False
        try:
            signature = bytes.fromhex(signature_hex)
            if signature.hex() != signature_hex:
                return False
            self._key.verify(signature, domain + content)
        except (InvalidSignature, ValueError):
            return False
        return True


class Signer:
    """The private half: signs in the authority's name."""

    def __init__(self, key: Ed25519PrivateKey) -> None:
        self._key = key
        self.authority = Authority(key.public_key().public_bytes_raw().hex())

    def sign(self, domain: bytes, content: bytes) -> str:
        """The signature over `content` in `domain`, 128 hex digits; the same content gives the same one."""
        return self._key.sign(domain + content).hex()


def keys_folder() -> Path | None:
    """Where private keys are looked for; nothing is made.  None for a user without a home folder."""
    if given := os.environ.get(KEYS_VARIABLE):
        return expanded(given).absolute()
    folder = data_folder()
    return None if folder is None else folder / "keys"


def key_path(authority: Authority) -> Path:
    """The file of an authority's private key.  Raises: RegistryError for a user without a home folder."""
    if (folder := keys_folder()) is None:
        raise RegistryError(f"this user has no home folder for private keys; set {KEYS_VARIABLE} to a folder")
    return folder / f"{authority.fingerprint}.pem"


def new_key() -> tuple[Signer, Path]:
    """A new key pair, its private half on the disk before anything is signed with it.

    Raises: RegistryError if the folder cannot be made or written.
    """
    # Most who ask a registry sign nothing, and its forms of keys take 6 ms to load.
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    key = Ed25519PrivateKey.generate()
    content, signer = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()), Signer(key)
    path = key_path(signer.authority)
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with whole_file(path, private=True) as temporary:
            temporary.write_bytes(content)
        # The folder's entry is written to the disk too: without its key, a registry is useless after a power cut.
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        raise RegistryError(
            f"the registry's private key cannot be written to {path.parent} ({error.strerror}); "
            f"set {KEYS_VARIABLE} to a folder that you may write"
        ) from error
    return signer, path


def key_of(authority: Authority) -> Signer:
    """The private half of an authority, from its file.

    Raises: RegistryError if it is not in the keys folder, or the file there holds no such key.
    """
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    path = key_path(authority)
    try:
        key = load_pem_private_key(read_regular(path), password=None)
    except FileNotFoundError as error:
        raise RegistryError(
            f"the private key of authority {authority.fingerprint} is looked for at {path}, and is not there; bring "
            f"that file, or set {KEYS_VARIABLE} to the folder that holds it",
            fingerprint=authority.fingerprint,
            path=str(path),
        ) from error
    except (OSError, TypeError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it holds no plain PEM key"
        raise RegistryError(f"private key {path} cannot be read ({reason}); restore it from a copy") from error
    if not isinstance(key, Ed25519PrivateKey) or Signer(key).authority.public_hex != authority.public_hex:
        raise RegistryError(
            f"private key {path} is another one; put the key with fingerprint {authority.fingerprint} there"
        )
    return Signer(key)


LONGEST = 200
#: How a studio's tokens begin (`moireid_studio/auth/tokens.py`); a user may enter one as their name by mistake.
TOKEN = "moireid_"


def account() -> str:
    """The account that this process runs as, by the operating system."""
    try:
        return f"account {pwd.getpwuid(os.getuid()).pw_name}"
    except KeyError:
        return f"account {os.getuid()}"


def as_fingerprint(text: str) -> str:
    """A fingerprint as people write it: any case, with blanks or colons.  Raises: SpecError if it is none."""
    digits = re.sub(r"[\s:]", "", text).lower()
    if not re.fullmatch(f"[0-9a-f]{{{FINGERPRINT_DIGITS}}}", digits):
        raise SpecError(
            f"fingerprint {text[:80]!r} is none; give the {FINGERPRINT_DIGITS} hex digits that `moireid registry init` "
            "prints for those who run the registry"
        )
    return digits


def checked_actor(text: str) -> str:
    """The actor as it is logged.  Raises: RegistryError if it is no line of text, or a secret."""
    actor = " ".join(text.split())
    if not actor or len(actor) > LONGEST or not actor.isprintable():
        raise RegistryError(
            f"actor {text[:80]!r} cannot be logged; give a name on one line of at most {LONGEST} letters"
        )
    if TOKEN in actor:
        raise RegistryError("the actor is a studio's token, which is a secret; give a name, and revoke that token")
    return actor
