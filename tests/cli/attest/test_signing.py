"""`verify --sign` as it is typed.  Each test states what it would catch."""

from __future__ import annotations

import base64
import json
import os
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from kit.coded_films import first_frames
from kit.places import FILMS
from kit.signing import certified_key, new_key, pem_of, public_pem_of
from moireid.cli.main import moireid
from moireid.verifier.session import film as judging

BADGE = ("--badge", str(FILMS / "badge.json"))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a film, a key without and one with a certificate."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    first_frames(FILMS / "genuine_1.0m.mp4", tmp_path / "film.mp4", 70)
    key = new_key("ed25519")
    (tmp_path / "key.pem").write_bytes(pem_of(key))
    (tmp_path / "pub.pem").write_bytes(public_pem_of(key))
    certified_key(tmp_path / "desk.pem", "p256")
    return tmp_path


def ran(*words: str) -> Result:
    done = CliRunner().invoke(moireid, words)
    assert "inside moireid" not in done.output, done.output
    return done


def test_a_verdict_is_signed_in_every_form(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a film that is decoded where the key is; another report printed than signed; a file left out."""

    def never(*given: object, **more: object) -> None:
        raise AssertionError("a film is judged in the process that has the key")

    monkeypatch.setattr(judging, "verify", never)
    monkeypatch.setattr("moireid.verifier.verify", never)
    command = ["verify", "film.mp4", *BADGE, "--sign", "desk.pem", "--attest", "verdict.json", "--c2pa", "sidecar"]
    done = ran(*command, "--report", "report", "--json")
    assert done.exit_code == 0, done.output
    printed = json.loads(done.stdout)
    assert "on no trust list" in done.stderr and "signed verdict: verdict.json" in done.stderr
    envelope = json.loads((here / "verdict.json").read_text())
    assert json.loads(base64.b64decode(envelope["payload"]))["predicate"] == printed
    assert printed["registry"] is None
    assert {"film.c2pa", "report", "verdict.json"} <= set(os.listdir(here))
    checked = ran("attest", "check", "verdict.json", "--film", "film.mp4", "--key", "desk.pem")
    assert checked.exit_code == 0 and checked.stdout.startswith("HOLDS: film.mp4 was judged ACCEPT")
    # Nothing is replaced unasked, and the film is read for nothing.
    again = ran(*command)
    assert again.exit_code == 2 and "verdict.json exists already; add --overwrite" in again.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--attest", "v.json"], "--attest needs a key"),
        (["--c2pa", "embed"], "--c2pa needs a key"),
        (["--sign", "key.pem"], "needs a place for the signed verdict"),
        (["--sign", "none.pem", "--attest", "v.json"], "none.pem cannot be read"),
        (["--sign", "pub.pem", "--attest", "v.json"], "no private key"),
        (["--sign", "key.pem", "--c2pa", "sidecar"], "a certificate that an authority issued"),
        (["--sign", "key.pem", "--attest", "film.mp4", "--overwrite"], "is a file that is read here"),
        (["--sign", "key.pem", "--attest", "./key.pem", "--overwrite"], "is a file that is read here"),
        (["--sign", "key.pem", "--attest", "v.json", "--pipeline", "published"], "own pipeline"),
        (["--sign", "key.pem", "--attest", "."], "--attest"),
    ],
)
def test_a_wish_that_cannot_be_is_refused_before_the_film_is_read(here: Path, options: list[str], words: str) -> None:
    """Catches: a minute of work thrown away, a film or a key written over, an option that does nothing in silence."""
    before = {name: (here / name).stat().st_mtime_ns for name in os.listdir(here)}
    done = CliRunner().invoke(moireid, ["verify", "film.mp4", *BADGE, *options])
    message = done.stderr or str(done.exception)
    assert done.exit_code == 2 and words in message and done.stdout == "", done.output
    assert {name: (here / name).stat().st_mtime_ns for name in os.listdir(here)} == before


@pytest.mark.parametrize(
    "options",
    [
        ["--badge", "read", "--attest", "read"],
        ["--claim", "Ada", "--bundle", "read", "--attest", "link"],
        ["--claim", "Ada", "--registry", "sqlite:///read", "--attest", "read"],
        ["--badge", "signals.csv", "--attest", "v.json", "--report", "."],
    ],
)
def test_what_is_read_is_not_written_over(here: Path, options: list[str]) -> None:
    """Catches: --overwrite that takes the bundle, the badge or the registry which the verdict rests on."""
    shutil.copy(BADGE[1], here / "read")
    shutil.copy(BADGE[1], here / "signals.csv")
    (here / "link").symlink_to("read")
    done = ran("verify", "film.mp4", *options, "--sign", "key.pem", "--overwrite")
    assert done.exit_code == 2 and "is a file that is read here" in done.stderr, done.output
    assert (here / "read").read_bytes() == (here / "signals.csv").read_bytes() == Path(BADGE[1]).read_bytes()
