"""What a witness signs, and what it never signs.  Each test names the wrong implementation that it catches."""

from __future__ import annotations

import sqlite3
import stat
from contextlib import closing

import pytest

from kit.witnesses import Log, leaves_of, reading
from moireid.errors import SpecError
from moireid.registry.checkpoints.cosignature import cosigned_at
from moireid.registry.merkle import consistency_proof
from moireid.registry.witness.request import MOST_STEPS, SIZE_TYPE, AddRequest
from moireid.registry.witness.state import Witness


def status(witness: Witness, request: bytes) -> int:
    return witness.answer(request).status


@pytest.fixture
def at_five(witness, log) -> Witness:
    """A witness that signed five entries."""
    assert status(witness, log.request(leaves_of(5), 0)) == 200
    return witness


def test_a_log_that_grows_is_signed_each_time(witness, log):
    """Catches: a signature that does not verify; extension lines that are not signed; a first size that is refused."""
    for old, new in ((0, 1), (1, 2), (2, 8), (8, 13), (13, 13)):
        note = log.note(leaves_of(new))
        steps = consistency_proof(reading(leaves_of(new)), new, old) if old else []
        answer = witness.answer(AddRequest(old, steps, note).to_bytes())
        assert answer.status == 200
        assert cosigned_at(note.rpartition("— ")[0] + answer.text, witness.public) is not None


def test_another_old_size_gets_the_size_that_the_witness_knows(at_five, log):
    """Catches: a rollback of what is kept; an answer of another type or without its newline."""
    for old, count in ((0, 5), (4, 5), (4, 8), (3, 3), (0, 9)):
        answer = at_five.answer(log.request(leaves_of(count), old))
        assert (answer.status, answer.text, answer.kind) == (409, "5\n", SIZE_TYPE)
    assert status(at_five, log.request(leaves_of(8), 5)) == 200


def test_a_fork_is_never_signed(at_five, log):
    """Catches: a proof that is not looked at; another tree of the same size; a state that a refusal moves on."""
    for forked in (leaves_of(9, 4, "b"), leaves_of(9, 0, "b")):
        assert status(at_five, log.request(forked, 5)) == 422
    assert status(at_five, log.request(leaves_of(5, 4, "b"), 5)) == 409
    assert status(at_five, log.request(leaves_of(8), 5, [])) == 422
    assert status(at_five, log.request(leaves_of(8), 5, [bytes(32)] * 3)) == 422
    assert status(at_five, log.request(leaves_of(5), 5, [bytes(32)])) == 422
    assert at_five.answer(log.request(leaves_of(8), 0)).text == "5\n"


def test_a_first_checkpoint_has_no_proof(witness, log):
    """Catches: hashes after an old size of 0, which another witness refuses."""
    assert status(witness, log.request(leaves_of(3), 0, [bytes(32)])) == 422


def test_only_logs_that_it_follows_and_their_keys_count(witness, log):
    """Catches: a stranger's log; a stranger's key under a log's name; a key of the right name and id alone."""
    assert status(witness, Log("example.com/other").request(leaves_of(3), 0)) == 404
    assert status(witness, Log("example.com/log").request(leaves_of(3), 0)) == 403
    forged = log.note(leaves_of(3)).replace("\n3\n", "\n4\n")
    assert status(witness, AddRequest(0, [], forged).to_bytes()) == 403
    two = log.note(leaves_of(3)) + "— another.example/key " + "A" * 96 + "\n"
    assert status(witness, AddRequest(0, [], two).to_bytes()) == 200


@pytest.mark.parametrize(
    "change",
    [
        lambda text: b"",
        lambda text: b"\xff\xfe",
        lambda text: text.replace(b"old 0", b"old 00"),
        lambda text: text.replace(b"old 0", b"old -1"),
        lambda text: text.replace(b"old 0", "old ٣".encode()),
        lambda text: text.replace(b"old 0", b"old  0"),
        lambda text: text.replace(b"old 0", b"old 0\nAAAA"),
        lambda text: text.replace(b"old 0", b"old 0" + b"\n" + b"\n".join([b"A" * 43 + b"="] * (MOST_STEPS + 1))),
        lambda text: text.replace(b"old 0", b"old 9"),
        lambda text: text.replace(b"\n3\n", b"\n03\n"),
        lambda text: text.replace(b"\n\n", b"\n"),
        lambda text: text[:-1],
        lambda text: text.replace(b"old 0", b"old 0\r"),
    ],
)
def test_what_is_no_request_is_refused_and_nothing_is_kept(witness, log, change):
    """Catches: sizes that two programs read in two ways; an error in the place of an answer."""
    request = log.request(leaves_of(3), 0)
    assert status(witness, change(request)) == 400
    assert status(witness, request) == 200


def test_key_and_state_stay_and_belong_to_one_name(at_five, log, tmp_path):
    """Catches: a new key at each start; a state that is lost with the program; one key under two names."""
    path = tmp_path / "witness.sqlite3"
    again = Witness(path, "witness.example/w1", [log.public])
    assert again.public == at_five.public
    assert again.answer(log.request(leaves_of(8), 0)).text == "5\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    for name, match in (("witness.example/w2", "is the state of witness"), ("a b", "is no name"), ("", "is no name")):
        with pytest.raises(SpecError, match=match):
            Witness(path, name, [log.public])
    with pytest.raises(SpecError, match="two of the logs"):
        Witness(path, "witness.example/w1", [log.public, Log("example.com/log").public])
    (tmp_path / "text").write_text("no database" * 1000)
    for wrong in (tmp_path / "text", tmp_path / "absent" / "file", tmp_path):
        with pytest.raises(SpecError, match="cannot be opened"):
            Witness(wrong, "w", [log.public])


def test_nothing_is_signed_that_is_not_on_the_disk(at_five, log, tmp_path):
    """Catches: a signature that leaves although the state could not be written: a restart would sign another log."""
    path = tmp_path / "witness.sqlite3"
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("CREATE TRIGGER no BEFORE INSERT ON logs BEGIN SELECT RAISE(ABORT, 'the disk is full'); END")
        with pytest.raises(sqlite3.Error):
            at_five.answer(log.request(leaves_of(8), 5))
        database.execute("DROP TRIGGER no")
    assert at_five.answer(log.request(leaves_of(8), 0)).text == "5\n"


def test_the_same_checkpoint_again_is_not_written(at_five, log, tmp_path):
    """Catches: a stranger with a public checkpoint who wears out the disk."""
    before = (tmp_path / "witness.sqlite3").stat().st_mtime_ns
    assert status(at_five, log.request(leaves_of(5), 5)) == 200
    assert (tmp_path / "witness.sqlite3").stat().st_mtime_ns == before
