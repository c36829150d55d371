"""The name in a signer's certificate, by the word of a trusted authority.  Each test names what it catches."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from cryptography import x509

from kit.signing import certificate, new_key, pem_of_certificates
from moireid.attest.signing_keys import SigningKey
from moireid.cli.main import moireid

Sign = Callable[..., str]
KEYS = {name: new_key("p256") for name in ("root", "desk", "thief", "other root")}
ROOT = certificate("Root", KEYS["root"], "Root", KEYS["root"], authority=True)
#: An authority that anybody made, under the trusted one's name.
FALSE_ROOT = certificate("Root", KEYS["other root"], "Root", KEYS["other root"], authority=True)


def issued(name: str, key: str, by: str = "root", issuer: str = "Root", **more: object) -> x509.Certificate:
    return certificate(name, KEYS[key], issuer, KEYS[by], **more)  # type: ignore[arg-type]


DESK = issued("Famous Newsroom", "desk")


def checked(folder: Path, sign: Sign, key: str, *chain: x509.Certificate, identity: str = "Famous Newsroom") -> Result:
    (folder / "verdict.json").write_text(sign(SigningKey(KEYS[key], chain)))
    (folder / "root.pem").write_bytes(pem_of_certificates(ROOT))
    words = ["attest", "check", str(folder / "verdict.json"), "--certificate-identity", identity]
    done = CliRunner().invoke(moireid, [*words, "--certificate-authority", str(folder / "root.pem")])
    assert "inside moireid" not in done.output, done.output
    return done


def test_a_name_counts_by_the_word_of_a_trusted_authority(tmp_path: Path, sign: Sign) -> None:
    """Catches: a chain that is believed though it leads nowhere; a check that only compares names."""
    done = checked(tmp_path, sign, "desk", DESK, ROOT)
    assert done.exit_code == 0 and "of the name that you gave, by an authority that you trust" in done.output
    # The root need not be in the envelope.
    assert checked(tmp_path, sign, "desk", DESK).exit_code == 0
    words = ["--certificate-identity", "Famous Newsroom", "--certificate-authority", str(tmp_path / "root.pem")]
    done = CliRunner().invoke(moireid, ["attest", "check", str(tmp_path / "verdict.json"), *words, "--json"])
    assert json.loads(done.stdout)["signer"]["expected_by"] == ["certificate"]


CHAINS = {
    "self-signed": (issued("Famous Newsroom", "thief", "thief", "Famous Newsroom"),),
    "self-signed authority": (issued("Famous Newsroom", "thief", "thief", "Famous Newsroom", authority=True),),
    "authority of the same name": (issued("Famous Newsroom", "thief", "other root"), FALSE_ROOT),
    "by a signer": (issued("Famous Newsroom", "thief", "desk", "Famous Newsroom"), DESK),
    "expired": (issued("Famous Newsroom", "thief", begins=timedelta(days=-9), ends=timedelta(days=-1)),),
    "of another key": (DESK,),
    "none": (),
}


@pytest.mark.parametrize("name", CHAINS)
def test_a_name_that_no_trusted_authority_gave_never_holds(tmp_path: Path, sign: Sign, name: str) -> None:
    """Catches: anybody's own certificate in a newsroom's name; one that a signer, who is no authority, issued."""
    done = checked(tmp_path, sign, "thief", *CHAINS[name])
    assert done.exit_code == 1 and done.output.startswith("DOES NOT HOLD"), done.output


def test_a_name_without_an_authority_is_refused(tmp_path: Path, sign: Sign) -> None:
    """Catches: a name that counts by the word of the one who made the certificate."""
    (tmp_path / "verdict.json").write_text(sign(SigningKey(KEYS["desk"], (DESK,))))
    for option in ("--certificate-identity", "--certificate-authority"):
        done = CliRunner().invoke(moireid, ["attest", "check", str(tmp_path / "verdict.json"), option, "x"])
        assert done.exit_code == 2 and "together" in done.stderr, done.output
