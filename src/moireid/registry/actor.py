"""Who does something to the registry: an account of this machine, or a studio's token.

The log holds an actor as a commitment: SHA-256 of the text and of a salt that is drawn for this actor once.  Text and
salt lie in the table `actors`, from which they can be erased; the log's chain is untouched by that, and without the
salt nobody can try names against it.
"""

from __future__ import annotations

import os
import pwd
import secrets

from moireid.errors import RegistryError
from moireid.registry.canonical import canonical_json, sha256_hex

LONGEST = 200
SALT_BYTES = 16
DOMAIN = b"moireid registry actor 1\n"
#: How a studio's tokens begin (`web/auth/tokens.py`): whoever gives one as their name has mistaken the field.
TOKEN = "moireid_"


def account() -> str:
    """The account that this process runs as, by the operating system."""
    try:
        return f"account {pwd.getpwuid(os.getuid()).pw_name}"
    except KeyError:
        return f"account {os.getuid()}"


def checked_actor(text: str) -> str:
    """The actor as it is logged.  Raises: RegistryError where it is no line of text, or a secret."""
    actor = " ".join(text.split())
    if not actor or len(actor) > LONGEST or not actor.isprintable():
        raise RegistryError(
            f"actor {text[:80]!r} cannot be logged; give a name on one line of at most {LONGEST} letters"
        )
    if TOKEN in actor:
        raise RegistryError("the actor is a studio's token, which is a secret; give a name, and revoke that token")
    return actor


def new_salt() -> str:
    """A salt of chance, hex digits: with it a commitment tells nothing to whoever guesses what it covers."""
    return secrets.token_hex(SALT_BYTES)


def commitment(actor: str, salt: str) -> str:
    """The actor as the log holds it, 64 hex digits."""
    return sha256_hex(DOMAIN + canonical_json({"actor": actor, "salt": salt}).encode())
