"""A witness's server against clients that are slow, many or wrong, and against kills.

Each test names the wrong implementation that it catches.
"""

from __future__ import annotations

import http.client
import random
import socket
import struct
import threading
import time
from pathlib import Path
from urllib.parse import urlparse

import pytest

from kit.witnesses import Log, leaves_of, root_of, serving, started
from moireid.registry.checkpoints.checkpoint import tree_head
from moireid.registry.checkpoints.cosignature import cosigned_at
from moireid.registry.checkpoints.note import parted
from moireid.registry.checkpoints.web import exchange
from moireid.registry.witness import server as served
from moireid.registry.witness.request import MOST_BYTES, SIZE_TYPE


def line_to(address: str) -> socket.socket:
    where = urlparse(address)
    return socket.create_connection((where.hostname, where.port), timeout=20)


def answered(address: str, text: bytes) -> bytes:
    """What the server sends for a text, until it closes."""
    with line_to(address) as line:
        line.sendall(text)
        line.shutdown(socket.SHUT_WR)
        found = b""
        while more := line.recv(65536):
            found += more
        return found


def test_one_connection_may_ask_twice(witness, log):
    """Catches: a connection that ends with each answer, though C2SP asks for it to go on; a missing content type."""
    with serving(witness) as address:
        where = urlparse(address)
        line = http.client.HTTPConnection(where.hostname, where.port, timeout=10)
        for old, count, status in ((0, 3, 200), (0, 3, 409), (3, 5, 200)):
            line.request("POST", "/add-checkpoint", log.request(leaves_of(count), old))
            answer = line.getresponse()
            assert answer.status == status
            text = answer.read()
            if status == 409:
                assert (text, answer.headers["Content-Type"]) == (b"3\n", SIZE_TYPE)
        line.close()


@pytest.mark.parametrize(
    ("text", "status"),
    [
        (b"POST /other HTTP/1.1\r\nContent-Length: 0\r\n\r\n", b"404"),
        (b"GET /add-checkpoint HTTP/1.1\r\n\r\n", b"501"),
        (b"POST /add-checkpoint HTTP/1.1\r\n\r\n", b"411"),
        (b"POST /add-checkpoint HTTP/1.1\r\nContent-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\nabc", b"411"),
        (b"POST /add-checkpoint HTTP/1.1\r\nContent-Length: -1\r\n\r\n", b"411"),
        (b"POST /add-checkpoint HTTP/1.1\r\nContent-Length: " + b"9" * 40 + b"\r\n\r\n", b"413"),
        (b"POST /add-checkpoint HTTP/1.1\r\nContent-Length: %d\r\n\r\n" % (MOST_BYTES + 1), b"413"),
        (b"POST /add-checkpoint HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc", b"400"),
        (b"POST /add-checkpoint HTTP/1.1\r\n" + b"A: b\r\n" * 200 + b"\r\n", b"431"),
    ],
)
def test_what_is_no_request_gets_its_status(witness, text, status):
    """Catches: a length that is believed; a body without an end; a second request that is hidden in a body."""
    with serving(witness) as address:
        found = answered(address, text)
    assert status in found.split(b"\r\n")[0] and found.count(b"HTTP/1.1") <= 1


def test_a_client_that_sends_without_an_end_is_cut_off(witness):
    """Catches: headers of any length in the memory of the witness."""
    with serving(witness) as address, line_to(address) as line:
        line.sendall(b"POST /add-checkpoint HTTP/1.1\r\n")
        sent = 0
        with pytest.raises(OSError):
            for _ in range(1000):
                line.sendall(b"A: " + b"b" * 60000 + b"\r\n")
                sent += 60000
                time.sleep(0.01)
        assert sent < 30 * served.MOST_SENT


def test_slow_clients_end_and_their_places_come_back(witness, log, monkeypatch):
    """Catches: a wait for each byte, so that one byte every few seconds holds a place for ever."""
    monkeypatch.setattr(served, "LASTS_S", 1.0)
    with serving(witness) as address:
        lines = [line_to(address) for _ in range(served.MOST_CLIENTS)]
        began = time.monotonic()
        while time.monotonic() - began < 2.0:
            for line in lines:
                try:
                    line.sendall(b"P")
                except OSError:
                    continue
            time.sleep(0.2)
        assert exchange(f"{address}/add-checkpoint", 1000, 10, log.request(leaves_of(3), 0)).status == 200
        for line in lines:
            line.close()


def test_silent_clients_keep_no_one_out(witness, log):
    """Catches: a stranger who takes all places by saying nothing, again and again, so that no log is signed."""
    with serving(witness) as address:
        lines = [line_to(address) for _ in range(served.MOST_CLIENTS)]
        began = time.monotonic()
        assert exchange(f"{address}/add-checkpoint", 1000, 10, log.request(leaves_of(3), 0)).status == 200
        assert time.monotonic() - began < 5.0
        for line in lines:
            line.close()


def test_clients_that_go_away_fill_no_disk(witness, log, capfd):
    """Catches: a line on stderr for each connection that a stranger resets."""
    with serving(witness) as address:
        for _ in range(20):
            with line_to(address) as line:
                line.sendall(b"POST /add-checkpoint HTTP/1.1\r\nContent-Le")
                line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        assert exchange(f"{address}/add-checkpoint", 1000, 10, log.request(leaves_of(3), 0)).status == 200
        time.sleep(0.5)
    assert capfd.readouterr().err == ""


def test_no_more_clients_than_there_are_places(witness, log):
    """Catches: a thread for each of any number of connections."""
    with serving(witness) as address:
        before = threading.active_count()
        lines = [line_to(address) for _ in range(3 * served.MOST_CLIENTS)]
        time.sleep(0.5)
        assert threading.active_count() - before <= served.MOST_CLIENTS
        for line in lines:
            line.close()
        for _ in range(50):
            try:
                assert exchange(f"{address}/add-checkpoint", 1000, 10, log.request(leaves_of(3), 0)).status == 200
                break
            except OSError:
                time.sleep(0.1)
        else:
            pytest.fail("no place came back")


def test_many_clients_at_once_get_one_history(witness, log):
    """Catches: a state that is read before it is locked, so that two logs are signed at one time."""
    signed: list[bytes] = []

    def push(address: str, name: str) -> None:
        old = 0
        for count in range(1, 30):
            leaves = leaves_of(count, 0, name)
            answer = exchange(f"{address}/add-checkpoint", 1000, 20, log.request(leaves, min(old, count)))
            if answer.status == 200:
                signed.append(root_of(leaves))
            elif answer.status == 409:
                old = int(answer.content)

    with serving(witness) as address:
        threads = [threading.Thread(target=push, args=(address, name)) for name in "abcd"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    one_history = [{root_of(leaves_of(count, 0, name)) for count in range(1, 30)} for name in "abcd"]
    assert signed and any(set(signed) <= roots for roots in one_history)


@pytest.mark.parametrize("kills", [6, pytest.param(40, marks=pytest.mark.slow)])
def test_a_witness_that_is_killed_never_signs_two_logs(tmp_path: Path, kills):
    """Catches: an answer before the state is on the disk: after a kill the other of two logs would be signed.

    A log with two histories, which differ from the fourth entry on, offers both to the witness as fast as it can; the
    program is killed at any time.  All that was ever signed must be of one history.
    """
    rng, log = random.Random(36), Log("example.com/two")
    sizes: dict[str, list[int]] = {"a": [], "b": []}
    state, public = tmp_path / "witness.sqlite3", None
    for _ in range(kills):
        process, address, key = started(state, "witness.example/w1", log.public)
        timer = threading.Timer(rng.uniform(0.02, 0.5), process.kill)
        timer.start()
        old = 0
        try:
            assert public in (None, key)
            public = key
            while True:
                name = rng.choice("ab")
                count = old + rng.randrange(3)
                leaves = leaves_of(max(count, 1), 3, name)
                answer = exchange(f"{address}/add-checkpoint", 1000, 5, log.request(leaves, min(old, len(leaves))))
                if answer.status == 409:
                    old = int(answer.content)
                if answer.status == 200:
                    note = log.note(leaves)
                    assert cosigned_at(f"{parted(note)[0]}\n{answer.content.decode()}", public) is not None
                    sizes[name].append(tree_head(note).size)
                    old = len(leaves)
        except OSError:
            pass
        finally:
            timer.cancel()
            process.kill()
            process.wait()
            process.stdout.close()
    assert max(sizes["a"] + sizes["b"]) > 3
    assert not {name for name, found in sizes.items() if max(found, default=0) > 3} >= {"a", "b"}
