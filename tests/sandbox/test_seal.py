"""A sealed process is asked to do what a hostile film would.  Each test names the fault that it catches."""

from __future__ import annotations

import errno
import os
import platform
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import moireid
from kit.places import TESTS
from moireid.sandbox import landlock
from moireid.sandbox import seal as sealing
from moireid.sandbox.file_access import Reach, open_parts, reach
from moireid.sandbox.process import Child, ForkServer, ProcessEnd, start
from moireid.sandbox.seal import MEANS, ProcessLimits, missing

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such means")
SOURCE = Path(moireid.__file__).parent.parent
WORK = "kit.sealed_work:act"
ROOMY = ProcessLimits(512 << 20, cpu_s=60)
Begin = Callable[..., Child]


@dataclass(frozen=True)
class Place:
    """A machine as a hostile film finds it: a key, its own film, another film, and servers that listen."""

    folder: Path
    key: Path
    film: Path
    other: Path
    tcp: int
    udp: int
    unix: str


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Place]:
    monkeypatch.setenv("MOIREID_KEYS", str(tmp_path / "keys"))
    monkeypatch.setenv("PGPASSWORD", "hidden")
    (tmp_path / "keys").mkdir()
    (tmp_path / "scratch").mkdir()
    names = ("keys/authority.pem", "film.mp4", "other.mp4")
    for name in names:
        (tmp_path / name).write_text(f"content of {name}")
    with (
        socket.create_server(("127.0.0.1", 0)) as tcp,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp,
        socket.socket(socket.AF_UNIX) as unix,
        socket.socket(socket.AF_UNIX) as abstract,
    ):
        udp.bind(("127.0.0.1", 0))
        unix.bind(str(tmp_path / "unix"))
        abstract.bind(f"\0{tmp_path}")
        unix.listen()
        abstract.listen()
        ports = tcp.getsockname()[1], udp.getsockname()[1]
        yield Place(tmp_path, *(tmp_path / name for name in names), *ports, str(tmp_path / "unix"))


@pytest.fixture(params=["program", "fork"])
def begin(request: pytest.FixtureRequest, place: Place) -> Iterator[Begin]:
    """Begins a process, in each way; all are ended after."""
    server, begun = ForkServer(WORK, sealed=True), list[Child]()

    def one(within: Reach | None) -> Child:
        made = {
            "program": partial(start, WORK),
            "fork": server.fork,
        }
        begun.append(made[request.param](ROOMY, place.folder / "scratch", within=within))
        return begun[-1]

    yield one
    for child in begun:
        child.kill()
    server._drop()


def ask(child: Child, *asked: Any) -> dict[str, Any]:
    child.send(asked)
    answer = child.hear(60)
    assert answer is not None
    return answer


#: How Landlock and the filter refuse.
REFUSED = (errno.EACCES, errno.EPERM, errno.ENOSYS)


def crimes(place: Place) -> list[tuple[Any, ...]]:
    """What must fail; each of them works in a process that is not sealed."""
    return [
        ("read", str(place.key)),
        ("read", str(place.other)),
        ("read in a thread", str(place.key)),
        ("list", str(place.folder / "keys")),
        ("write", str(place.folder / "new.txt")),
        ("write", str(place.other)),
        ("rights", str(place.key)),
        ("read by a link", str(place.key)),
        ("tcp", place.tcp),
        ("udp", place.udp),
        ("unix", place.unix),
        ("abstract", str(place.folder)),
        ("listen",),
        ("program",),
        ("fork",),
        ("signal", os.getpid()),
        ("ptrace", os.getppid()),
        ("environment", os.getpid()),
        ("signal by a file", os.getpid()),
        ("empty", str(place.film)),
    ]


@pytest.mark.claim("A sealed process reaches no network, program or file but its film")
def test_nothing_of_what_a_hostile_film_wants_can_be_done(begin: Begin, place: Place) -> None:
    """Catches: a seal that is reported and does not hold, one that threads escape, one that lets a thing through."""
    child = begin(reach(read=[place.film]))
    for crime in crimes(place):
        answer = ask(child, *crime)
        assert answer.get("errno") in REFUSED, (crime, answer)
    assert child.sealed == tuple(MEANS) and missing(child.sealed) is None
    assert place.other.read_text() == "content of other.mp4"
    # A program that replaces this process, after which it could not report anything.
    assert ask(child, "exec")["errno"] == errno.ENOSYS


def test_the_same_works_where_nothing_is_sealed(begin: Begin, place: Place) -> None:
    """Catches: crimes that fail for another reason, so that the test above shows nothing."""
    child = begin(None)
    for crime in crimes(place):
        if crime[0] != "ptrace":
            assert "done" in ask(child, *crime), crime
    assert child.sealed is None


@pytest.mark.skipif(platform.machine() != "x86_64", reason="other processors have one table of calls")
def test_a_call_of_another_table_ends_the_process(begin: Begin, place: Place) -> None:
    """Catches: only the thread that calls ended by the filter, so that the process is silent and is waited for."""
    child = begin(reach(read=[place.film]))
    child.send(("x32",))
    with pytest.raises(ProcessEnd, match="SIGSYS"):
        child.hear(20)


def test_what_old_kernels_leave_open_the_filter_refuses(begin: Begin, place: Place) -> None:
    """Catches: signals by a file's owner (Landlock knows them since its version 6), and a film that is emptied by
    a process that may read it (since version 3): both refused by the filter, whose answer comes first.
    """
    child = begin(reach(read=[place.film]))
    assert ask(child, "signal by a file", os.getpid())["errno"] == errno.ENOSYS
    assert ask(child, "empty", str(place.film))["errno"] == errno.ENOSYS
    assert place.film.read_text() == "content of film.mp4"
    # Twice: the second time the file is there, and is emptied rightly.
    assert ask(child, "scratch") == ask(child, "scratch") == {"done": "1"}


@pytest.mark.parametrize(("version", "reported"), [(2, False), (3, True)])
def test_a_list_of_files_that_lets_a_film_be_emptied_is_not_reported(
    monkeypatch: pytest.MonkeyPatch, version: int, reported: bool
) -> None:
    """Catches: "opens no file but its film" said where the filter is missing, and a reader may empty what it reads."""

    def refuse() -> None:
        raise OSError(errno.EINVAL, "no filter here")

    monkeypatch.setattr(sealing, "filter_calls", refuse)
    monkeypatch.setattr(sealing, "_close_files", lambda reach, scratch: True)
    monkeypatch.setattr(sealing, "_no_new_privileges", lambda: True)
    monkeypatch.setattr(sealing.os, "listdir", lambda path: ["1"])
    monkeypatch.setattr("moireid.sandbox.landlock.version", lambda: version)
    assert (sealing.FILES in sealing.seal(Reach(), "/tmp")) is reported


def test_what_its_work_needs_it_can_do(begin: Begin, place: Place) -> None:
    """Catches: a seal that no film can be judged within."""
    child = begin(reach(read=[place.film], write=[place.folder / "scratch"]))
    assert ask(child, "read", str(place.film)) == {"done": "content of film.mp4"}
    assert ask(child, "scratch")["done"] == "1" and ask(child, "numpy")["done"] == "200.0"
    assert "done" in ask(child, "threads") and ask(child, "read", "/proc/self/statm")["done"]
    assert ask(child, "write", str(place.folder / "scratch" / "frame.jpg"))["done"] == "1"


@pytest.mark.parametrize("begin", ["program", "fork"], indirect=True)
def test_its_environment_holds_nothing_private(begin: Begin, place: Place) -> None:
    """Catches: a database's password, or the place of the keys, in the environment of the process that decodes."""
    child = begin(reach(read=[place.film]))
    for name in ("PGPASSWORD", "MOIREID_KEYS"):
        assert ask(child, "variable", name)["refused"] == "KeyError"
        assert ask(child, "own environment", name) == {"done": "False"}
    assert ask(child, "variable", "PATH")["done"] == os.environ["PATH"]


def test_keys_within_what_may_be_read_stay_closed(begin: Begin, place: Place) -> None:
    """Catches: keys that are next to a collection of films, or anywhere, given away with what is above them; passwords
    in the environment of others, which is a file as well.
    """
    for above in (place.folder, "/"):
        child = begin(reach(read=[above]))
        assert ask(child, "read", str(place.other))["done"]
        assert ask(child, "read", str(place.key))["errno"] == errno.EACCES
        assert ask(child, "write", str(place.other))["errno"] == errno.EACCES
        assert ask(child, "environment", os.getpid())["errno"] in (*REFUSED, errno.ENOENT)


def test_a_film_next_to_the_keys_can_be_read(begin: Begin, place: Place) -> None:
    """Catches: a film in the program's own data folder that cannot be judged; its neighbours opened with it."""
    film = place.key.with_name("film.mp4")
    film.write_text("next to the key")
    child = begin(reach(read=[film]))
    assert ask(child, "read", str(film)) == {"done": "next to the key"}
    assert ask(child, "read", str(place.key))["errno"] == errno.EACCES


SCRIPT = """
import sys
from moireid.sandbox.seal import ProcessLimits
from moireid.sandbox.process import start
from moireid.sandbox.file_access import reach
child = start("kit.sealed_work:act", ProcessLimits(1 << 29), within=reach(read=[sys.argv[1]]))
for name in sys.argv[1:]:
    child.send(("read", name))
    print(child.hear(60))
child.send(("numpy",))
print(child.hear(60))
child.kill()
"""


def test_a_script_does_not_open_its_own_folder(tmp_path: Path) -> None:
    """Catches: a key next to a script, which a film may read since Python imports from a script's folder; a folder that
    is closed although the work's packages lie there.
    """
    names = [tmp_path / name for name in ("film.mp4", "key.pem", "script.py")]
    for name in names:
        name.write_text(SCRIPT)
    path = os.pathsep.join(str(folder) for folder in (SOURCE, TESTS))
    done = subprocess.run(
        [sys.executable, *map(str, (names[2], *names[:2]))],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    film, key, work = done.stdout.splitlines()
    assert "done" in film and f"'errno': {errno.EACCES}" in key and "200.0" in work, done


def test_all_but_what_is_closed_is_open(tmp_path: Path) -> None:
    """Catches: a closed folder's neighbours closed too, or its parent's parts left open."""
    for name in ("a/keys/deep", "a/b", "c", "a/keys2"):
        (tmp_path / name).mkdir(parents=True)
    closed, root = str(tmp_path / "a" / "keys"), str(tmp_path)
    assert open_parts(root, [closed]) == [str(tmp_path / name) for name in ("a/b", "a/keys2", "c")]
    assert open_parts(root, []) == [root] and open_parts(root, ["/elsewhere"]) == [root]
    assert open_parts(f"{closed}/deep", [closed]) == [] and open_parts(closed, [closed]) == []


def test_what_does_not_hold_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a system without these means called sealed."""
    assert sealing.seal.__module__ and missing(()) is not None
    assert missing(("no_new_privileges", "files")) == "could reach the network, programs and other processes"
    monkeypatch.setattr(sealing.sys, "platform", "darwin")
    assert sealing.seal(Reach(), "/tmp") == ()


GONE = """
import sys
from moireid.sandbox.landlock import READ_DIR, READ_FILE, restrict
restrict([(sys.argv[1], READ_FILE), ("/", READ_FILE | READ_DIR)])
print("sealed")
"""


@pytest.mark.skipif(landlock.version() == 0, reason="this kernel has no Landlock")
def test_a_path_that_has_gone_meanwhile_does_not_end_the_process(tmp_path: Path) -> None:
    """Catches: a process that fails to start as a temporary folder next to the film was removed in that moment."""
    done = subprocess.run(
        [sys.executable, "-c", GONE, str(tmp_path / "gone")], capture_output=True, text=True, check=False
    )
    assert done.stdout == "sealed\n", done.stderr
