"""Processes within limits, begun as a program and by a fork.  Each test names the fault that it catches."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

import moireid
from kit.places import TESTS
from moireid.sandbox.process import Child, ForkServer, ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits

WORK = "kit.sandbox_work:act"
ROOMY = ProcessLimits(256 << 20, cpu_s=20, file_bytes=1 << 16, answer_bytes=1 << 16)
Begin = Callable[..., Child]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ForkServer]:
    """A fork server that begins where a module lies that is not to be taken."""
    folder = tmp_path_factory.mktemp("here")
    (folder / "json.py").write_text("raise SystemExit('this is not the package')")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        made = ForkServer(WORK)
        made.warm_up()
    yield made
    made._drop()


@pytest.fixture(params=["program", "fork"])
def begin(request: pytest.FixtureRequest, server: ForkServer, tmp_path: Path) -> Iterator[Begin]:
    """Begins a process, either way; all are ended after."""
    begun: list[Child] = []

    def one(limits: ProcessLimits = ROOMY) -> Child:
        begun.append(start(WORK, limits, tmp_path) if request.param == "program" else server.fork(limits, tmp_path))
        return begun[-1]

    yield one
    for child in begun:
        child.kill()


def ask(child: Child, *asked: Any) -> dict[str, Any]:
    child.send(asked)
    answer = child.hear(60)
    assert answer is not None
    return answer


def end_of(child: Child, *asked: Any) -> tuple[str, str, bool]:
    with pytest.raises(ProcessEnd) as ended:
        ask(child, *asked)
    return ended.value.kind, ended.value.words, ended.value.ours


def test_it_talks_has_its_own_folder_and_leaves_nothing(begin: Begin, tmp_path: Path, monkeypatch) -> None:
    """Catches: modules of the present folder, temporary files that stay, a process that outlives its end."""
    (tmp_path / "json.py").write_text("raise SystemExit('this is not the package')")
    monkeypatch.chdir(tmp_path)
    child = begin()
    where = ask(child, "describe")
    assert Path(where["folder"]).parent == tmp_path and not where["json"].startswith(str(tmp_path))
    assert child.hear(0.0) is None and ask(child, "describe")["pid"] == where["pid"]
    child.kill()
    child.kill()
    assert not psutil.pid_exists(where["pid"]) and [path.name for path in tmp_path.iterdir()] == ["json.py"]


@pytest.mark.parametrize(
    ("asked", "kind", "words"),
    [
        (("crash",), "crash", "ended by itself (by SIGSEGV)"),
        (("leave",), "crash", "ended by itself (with exit code 7)"),
        (("grow", 1 << 30), "memory", ""),
        (("write", 1 << 17), "OSError", "File too large"),
        (("refuse",), "MediaError", "no film"),
        (("fail",), "LookupError", "nothing there"),
        (("raw", b"{"), "crash", "it said what cannot be read"),
        (("raw", b'{"ended": 1}'), "crash", "it said what cannot be read"),
        (("end",), "done", ""),
    ],
)
def test_how_it_ended_is_reported(begin: Begin, asked: tuple[Any, ...], kind: str, words: str) -> None:
    """Catches: limits that are not held, faults that are mixed up, words of a process that bring its starter down."""
    found, said, ours = end_of(begin(), *asked)
    assert found == kind and words in said and ours == (kind in ("MediaError", "done"))


def test_what_it_says_is_never_unpickled(begin: Begin, tmp_path: Path) -> None:
    """Catches: a pickle from a process that has read what a stranger made, which does here what it likes."""
    assert end_of(begin(), "trap", tmp_path / "sprung")[0] == "crash" and not (tmp_path / "sprung").exists()


def test_time_of_the_processor_is_limited_and_memory_that_is_allowed_is_given(begin: Begin) -> None:
    """Catches: a process that works on though no one waits for it; a limit that counts what it held before."""
    child = begin(ProcessLimits(256 << 20, cpu_s=1))
    assert ask(child, "grow", 200 << 20) == {"grown": 200 << 20}
    assert end_of(child, "spin") == ("crash", "ended by itself (by SIGKILL)", False)


def test_one_that_hangs_is_ended_from_another_thread(begin: Begin) -> None:
    """Catches: a wait without end for a process that was ended meanwhile."""
    child = begin()
    pid = ask(child, "describe")["pid"]
    child.send(("hang",))
    assert child.hear(0.1) is None
    threading.Timer(0.2, child.kill).start()
    with pytest.raises(ProcessEnd):
        child.hear(60)
    child.kill()
    assert not psutil.pid_exists(pid)


def test_one_that_promises_a_message_or_reads_none_does_not_block_its_starter(begin: Begin) -> None:
    """Catches: a wait for the rest of a message, or for a reader, that lasts as long as a hostile process likes."""
    large = bytes(1 << 24)
    for asked, wait in (("promise", lambda child: child.hear(0.3)), ("hang", lambda child: child.send(large, 0.3))):
        child, found = begin(), list[object]()
        assert ask(child, "describe")
        child.send((asked,))

        def waited(child: Child = child, wait: Callable[[Child], object] = wait, found: list[object] = found) -> None:
            try:
                found.append(wait(child))
            except ProcessEnd as ended:
                found.append(ended.kind)

        thread = threading.Thread(target=waited, daemon=True)
        thread.start()
        thread.join(20)
        assert found == [None if asked == "promise" else "crash"], asked
        child.kill()


def test_a_message_that_comes_in_parts_is_received_whole(begin: Begin) -> None:
    """Catches: what came before a wait ran out, lost; two messages in one piece taken for one."""
    child = begin()
    for body in (b'{"a": 1}', b'{"b": "' + b"x" * 60_000 + b'"}', b'{"c": 3}'):
        child.send(("raw", body))
    received: list[str] = []
    last = time.monotonic() + 60
    while len(received) < 3 and time.monotonic() < last:
        received += child.hear(0.0) or {}
    assert received == ["a", "b", "c"]


def test_a_fork_server_that_has_gone_is_started_again(tmp_path: Path) -> None:
    """Catches: a studio that judges no film any more after one bad moment; processes that outlive it."""
    server = ForkServer(WORK)
    first = server.fork(ROOMY, tmp_path)
    where = ask(first, "describe")
    psutil.Process(where["parent"]).kill()
    assert end_of(first, "hang")[0] == "crash"
    second = server.fork(ROOMY, tmp_path)
    assert ask(second, "describe")["parent"] != where["parent"]
    second.kill()
    server._drop()
    assert list(tmp_path.iterdir()) == []


KILLED = f"""
import os
from moireid.sandbox.process import ForkServer, start
from moireid.sandbox.seal import ProcessLimits
limits, server = ProcessLimits(1 << 28), ForkServer({WORK!r})
for child in (start({WORK!r}, limits), server.fork(limits)):
    child.send(("describe",))
    print(child.hear(60)["pid"], flush=True)
    child.send(("hang",))
os.kill(os.getpid(), 9)
"""


@pytest.mark.slow
def test_it_ends_with_the_one_who_started_it(tmp_path: Path) -> None:
    """Catches: processes that work on when no one waits for them any more."""
    path = os.pathsep.join([str(Path(moireid.__file__).parent.parent), str(TESTS)])
    environment = os.environ | {"PYTHONPATH": path, "TMPDIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", KILLED], env=environment, capture_output=True, text=True)
    pids = [int(word) for word in done.stdout.split()]
    assert len(pids) == 2, done.stderr
    last = time.monotonic() + 30
    while any(psutil.pid_exists(pid) for pid in pids):
        assert time.monotonic() < last
        time.sleep(0.05)
