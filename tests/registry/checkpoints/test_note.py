"""Signed notes, against the example of Go's `sumdb/note`.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import base64

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from moireid.registry.checkpoints.note import ED25519, VerifierKey, opened, parted, signed_note
from moireid.registry.keys import Signer

# The keys and the note of the documentation of golang.org/x/mod/sumdb/note.
SECRET = "AYEKFALVFGyNhPJEMzD1QIDr+Y7hfZx09iUvxdXHKDFz"
PUBLIC = "ARpc2QcUPDhMQegwxbzhKqiBfsVkmqq/LDE4izWy10TW"
TEXT = "If you think cryptography is the answer to your problem,\nthen you don't know what your problem is.\n"
LINE = "— PeterNeumann x08go/ZJkuBS9UG/SffcvIAQxVBtiFupLLr8pAcElZInNIuGUgYN1FFYC2pZSNXgKvqfqdngotpRZb6KE6RyyBwJnAM=\n"
PETER = Signer(Ed25519PrivateKey.from_private_bytes(base64.b64decode(SECRET)[1:]))


def test_a_note_is_that_of_another_implementation():
    """Catches: a domain before the text; a key id of other bytes; another dash, order or line end."""
    assert bytes.fromhex(PETER.authority.public_hex) == base64.b64decode(PUBLIC)[1:]
    assert VerifierKey("PeterNeumann", ED25519, base64.b64decode(PUBLIC)[1:]).id.hex() == "c74f20a3"
    assert signed_note(TEXT, "PeterNeumann", PETER) == f"{TEXT}\n{LINE}"
    assert opened(f"{TEXT}\n{LINE}", "PeterNeumann", PETER.authority) == TEXT


@pytest.mark.parametrize(
    "note",
    [
        f"{TEXT}\n{LINE}".replace("answer", "anwser"),
        f"{TEXT}\n{LINE}".replace("x08go/ZJ", "x08go/ZK"),
        f"{TEXT}\n{LINE}".replace("PeterNeumann", "EnochRoot"),
        TEXT,
        f"{TEXT}{LINE}",
        f"{TEXT}\n{LINE}"[:-1],
        f"{TEXT}\n— PeterNeumann !!!!\n",
        f"a\rb\n\n{LINE}",
    ],
)
def test_anything_else_is_refused(note):
    """Catches: a changed text or signature; a note without one; a reader that fails with another error."""
    with pytest.raises(ValueError):
        opened(note, "PeterNeumann", PETER.authority)


def test_the_text_ends_at_the_last_empty_line():
    """Catches: signatures looked for after the first empty line, so that a text can pretend to be some."""
    note = signed_note(f"one\n\n{LINE}\nthree\n", "PeterNeumann", PETER)
    assert parted(note)[0] == f"one\n\n{LINE}\nthree\n"
    assert opened(note, "PeterNeumann", PETER.authority) == parted(note)[0]
