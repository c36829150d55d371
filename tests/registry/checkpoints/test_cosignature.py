"""Cosignatures and keys, against examples that others published.  Each test names the wrong implementation it catches.

The examples are those of C2SP (tlog-cosignature, signed-note), of transparency-dev/formats, and a checkpoint of the
firmware log of the armored witness project.
"""

from __future__ import annotations

import base64
import time

import pytest

from kit.witnesses import Witness
from moireid.errors import RegistryError, SpecError
from moireid.registry.checkpoints.cosignature import (
    cosigned_at,
    signers,
    witness_keys,
)
from moireid.registry.checkpoints.note import COSIGNATURE, VerifierKey, parted, signatures_of
from moireid.registry.keys import NOTE, Authority

#: A witness's key for cosignatures, and a log's key with a checkpoint that it signed.
WITNESS_KEY = "remora.n621.de+da77ade7+BOvN63jn/bLvkieywe8R6UYAtVtNbZpXh34x7onlmtw2"
LOG_KEY = "transparency.dev-aw-ftlog-ci-3+3f689522+Aa1Eifq6rRC8qiK+bya07yV1fXyP156pEMsX7CFBC6gg"
FIRMWARE = """transparency.dev/armored-witness/firmware_transparency/ci/3
59
kOFMkeamIdrYFLx5zbWFhflak6dlEEDOU++fxYEZMBw=

— transparency.dev-aw-ftlog-ci-3 P2iVIt3Jsaha3E2i0MHdKZ6fgYJTgXO86nUsxKPVq6uTwRSclTSh/ELnDGbNL+XDyD3\
EkWIdL2AGGNmbN7IN2rB/7gE=
— ArmoredWitness-weathered-rain CnjfIAAAAABnGRrHjQi7IZQqVea4YnU/ADsv844r1ezGjvubUy1MMJm4as9bRiT70xNW\
Q67RCA76LMy7SdX4qJNIzL3eSS1BGFWqCw==
"""
TEXT = "example.com/log\n3\nCsUYapGGPo4dkMgIAUqom/Xajj7h2fB2MPA3j2jxq2I=\n"


def cosigned(*witnesses: Witness, at: float | None = None) -> str:
    return TEXT + "\n" + "".join(one.line(TEXT, at) for one in witnesses)


def test_a_published_checkpoint_of_another_program_is_read_and_its_signature_holds():
    """Catches: another order of lines; a signature over other bytes; a cosigned note that counts as damaged."""
    key = VerifierKey.parse(LOG_KEY)
    text, lines = parted(FIRMWARE)
    (signature,) = signatures_of(key, lines)
    assert Authority(key.public.hex()).signed(NOTE, text.encode(), signature.hex())


def test_a_line_that_another_program_made_by_the_specification_counts():
    """Catches: a time, an id or a signed message of our own layout, which no other witness's signature fits."""
    one = Witness("witness.example/w1")
    assert cosigned_at(cosigned(Witness("w2"), one, at=1679315147), VerifierKey.parse(one.key)) == 1679315147


def test_a_signature_of_a_known_witness_that_does_not_fit_is_an_error():
    """Catches: a signature over another text, time or by another key, that counts."""
    one = Witness("w1")
    public, note = VerifierKey.parse(one.key), cosigned(one, at=1679315147)
    assert cosigned_at(note, VerifierKey.parse(Witness("w1").key)) is None
    line = note.rpartition(" ")[2]
    content = bytearray(base64.b64decode(line))
    content[11] ^= 1
    later = note.replace(line.strip(), base64.b64encode(content).decode())
    for wrong in (later, note.replace("\n3\n", "\n4\n")):
        with pytest.raises(ValueError, match="does not fit"):
            cosigned_at(wrong, public)


def test_all_must_have_signed_and_no_key_counts_twice():
    """Catches: one witness whose two lines count as two; one key under two names."""
    one, two = Witness("w1"), Witness("w2")
    keys = witness_keys([one.key, two.key])
    assert set(signers(keys, cosigned(one, two), "x")) == {"w1", "w2"}
    for note in (cosigned(one), cosigned(one, one), cosigned(one, Witness("w2")), cosigned(one, Witness("w9"))):
        with pytest.raises(RegistryError, match="signed by 1 of 2") as refused:
            signers(keys, note, "x")
        assert refused.value.details["code"] == "not_witnessed"
    again = VerifierKey("other", COSIGNATURE, VerifierKey.parse(one.key).public)
    with pytest.raises(SpecError, match="count as one"):
        witness_keys([one.key, str(again)])


def test_old_and_future_signatures_do_not_count():
    """Catches: a signature of last year that covers a rollback; one of next year, that would count for ever."""
    one = Witness("w1")
    assert signers(witness_keys([one.key]), cosigned(one, at=time.time() - 6 * 86400), "x")
    for at in (time.time() - 8 * 86400, time.time() + 3600):
        with pytest.raises(RegistryError, match=r"days ago|a time to come"):
            signers(witness_keys([one.key]), cosigned(one, at=at), "x")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "bananas.example+12344556",
        "rekor.example+12345678+THIS_IS_NOT_BASE64!",
        "rekor.example+12345678+AwEB",
        WITNESS_KEY.replace("da77ade7", "00000000"),
        WITNESS_KEY.replace("remora", "a b"),
        LOG_KEY,
    ],
)
def test_what_is_no_key_of_a_witness_is_said_in_one_sentence(text, tmp_path):
    """Catches: a log's key that counts as a witness; a traceback; an empty file that asks for nothing."""
    for given in (text, tmp_path / "keys"):
        (tmp_path / "keys").write_text(f"# of a friend\n{text}\n")
        with pytest.raises(SpecError) as refused:
            witness_keys([str(given)])
        assert "\n" not in str(refused.value)
