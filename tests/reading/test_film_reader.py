"""Films are read by a process that can do nothing else.  Each test names the fault that it catches."""

from __future__ import annotations

import json
import os
import random
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
from click.testing import CliRunner, Result

from kit.coded_films import first_frames
from kit.film_taken_over import HostileOrder, SayingOrder
from kit.places import FILMS, TESTS
from moireid.badge import load_badge
from moireid.cli.main import moireid
from moireid.errors import MediaError
from moireid.reading import film_reader as reading
from moireid.reading.answers import FilmAnswer
from moireid.reading.film_reader import ANSWER_BYTES, Reader, film_reader
from moireid.sandbox.seal import MEANS
from moireid.verifier import Question, verify

linux = pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such means")


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The beginning of a true film."""
    return first_frames(FILMS / "genuine_1.0m.mp4", tmp_path_factory.mktemp("film") / "film.mp4", 70)


@pytest.fixture
def reader(film: Path) -> Iterator[Reader]:
    with film_reader([film]) as made:
        yield made


def read(reader: Reader, order: Any) -> FilmAnswer:
    return reader.read(order, lambda done, of: None)


@linux
@pytest.mark.parametrize(
    ("act", "words"),
    [("grow", "asks for more memory"), ("write", "File too large|Permission denied"), ("open", "Too many open files")],
)
def test_a_film_cannot_take_the_machine(reader: Reader, act: str, words: str) -> None:
    """Catches: memory, descriptors or a disk that a decoder may use up."""
    with pytest.raises(MediaError, match=words):
        read(reader, HostileOrder(act))


@pytest.mark.claim("A film cannot have another file read")
@linux
def test_a_film_cannot_read_another_file(reader: Reader, tmp_path: Path) -> None:
    """Catches: an order that is carried out before the seal, or without one."""
    (tmp_path / "key.pem").write_text("secret")
    with pytest.raises(MediaError, match="Permission denied"):
        read(reader, HostileOrder("steal", str(tmp_path / "key.pem")))
    assert reader.sealed == tuple(MEANS)


SEARCHED = """import os, sys
from pathlib import Path
from kit.film_taken_over import HostileOrder
from moireid.reading.film_reader import film_reader
with film_reader([Path("none.mp4")]) as reader:
    found = reader.read(HostileOrder("search"), lambda done, of: None).result["got"]
print(found, sys.argv[1], os.environ["PGPASSWORD"], *reader.sealed)
"""


@linux
def test_no_secret_of_the_command_is_in_the_memory_of_its_reader(film: Path) -> None:
    """Catches: a database's password, in a variable or an argument, in the memory of the process that decodes."""
    secrets = [f"hidden.{random.randbytes(6).hex()}" for _ in range(2)]
    program = [sys.executable, "-c", SEARCHED, f"postgresql://ada:{secrets[0]}@there/people"]
    variables = {"PATH": os.environ["PATH"], "PYTHONPATH": str(TESTS), "PGPASSWORD": secrets[1]}
    done = subprocess.run(program, env=variables, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["0", program[-1], secrets[1], *MEANS]


@linux
def test_nothing_is_waited_for_without_an_end(reader: Reader, film: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a stopped process that is waited for, and left behind."""
    monkeypatch.setattr(reading, "SILENCE_S", 1.0)
    with pytest.raises(MediaError, match=r"film\.mp4 does not answer"):
        read(reader, HostileOrder("stop"))
    reader._child.kill()
    assert not [one for one in psutil.Process().children() if one.status() == psutil.STATUS_STOPPED]


@linux
@pytest.mark.parametrize(
    "message",
    [
        {"progress": [1]},
        {"progress": ["\x1b[2J", 2]},
        {"ended": 3},
        {"signals": "x" * ANSWER_BYTES},
        b'{"result": NaN}',
        b'{"result": "\\ud800"}',
        b"[" * 100_000,
    ],
    ids=lambda message: str(message)[:30],
)
def test_a_message_that_is_none_ends_in_a_sentence(film: Path, message: Any) -> None:
    """Catches: progress of another shape, numbers and letters that JSON has not, which end in an internal error."""
    with film_reader([film]) as made, pytest.raises(MediaError, match="process that read"):
        made.read(SayingOrder(message), lambda done, of: None)


def ran(*words: str) -> Result:
    done = CliRunner().invoke(moireid, words)
    assert "inside moireid" not in done.output, done.output
    return done


@linux
def test_verify_says_how_it_read_the_film_and_judges_as_before(film: Path) -> None:
    """Catches: a verdict that the seal changes; a report that does not say that it was read without one."""
    command = ["verify", str(film), "--badge", str(FILMS / "badge.json"), "--json"]
    sealed, plain = ran(*command), ran(*command, "--unsealed")
    assert sealed.exit_code == plain.exit_code and not sealed.stderr
    assert re.fullmatch(r"note: the process that read the film could .*: as --unsealed asks\n", plain.stderr)
    found, here = json.loads(sealed.stdout), json.loads(plain.stdout)
    assert (found.pop("sealed"), here.pop("sealed")) == (list(MEANS), [])
    assert re.fullmatch(r"FFmpeg \S+ \(PyAV \S+\)", found["input"]["decoder"])
    in_python = verify(film, Question(load_badge(FILMS / "badge.json"))).to_json()
    del found["timing"], here["timing"]
    assert found == here and found["reasons"] == in_python["reasons"] and in_python["sealed"] == []


@linux
def test_where_nothing_seals_the_command_line_warns(film: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a seal that is reported though the kernel refuses it; a silence about it."""
    monkeypatch.setattr(Reader, "sealed", ("no_new_privileges",))
    done = ran("verify", str(film), "--badge", str(FILMS / "badge.json"), "--json")
    assert json.loads(done.stdout)["sealed"] == ["no_new_privileges"]
    assert done.stderr.startswith("note: the process that read the film could reach the network")


def test_what_a_key_signs_is_read_apart(film: Path, tmp_path: Path) -> None:
    """Catches: a film decoded in the process that holds the key, because --unsealed was given too."""
    command = ["verify", str(film), "--badge", str(FILMS / "badge.json"), "--sign", "k.pem", "--attest", "a.json"]
    done = ran(*command, "--unsealed")
    assert done.exit_code == 2 and "leave one of them out" in done.stderr
