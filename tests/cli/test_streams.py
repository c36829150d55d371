"""Closed streams, names that are no text, and interrupts.  Each test names the fault that it catches."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from kit.coded_films import first_frames
from kit.places import FILMS

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="streams and processes of Linux")
PROGRAM = "import sys\nfrom moireid.cli.main import main\nmain()\n"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The beginning of a true film."""
    return first_frames(FILMS / "genuine_1.0m.mp4", tmp_path_factory.mktemp("film") / "film.mp4", 100)


def verify(folder: Path, film: Path | bytes, *, shell: str = "") -> subprocess.CompletedProcess[bytes]:
    """`moireid verify`, started as a script; shell: what is done with its streams."""
    script = folder / "moireid"
    script.write_text(PROGRAM)
    words: list[Any] = [sys.executable, script, "verify", film, "--badge", FILMS / "badge.json"]
    return subprocess.run(["sh", "-c", f'exec "$@" {shell}', "sh", *words], capture_output=True, timeout=120)


@pytest.mark.parametrize("shell", [">&-", "<&-", "2>&-", ">&- <&-", "<&- >&- 2>&-", "2>/dev/full"])
def test_a_stream_that_cannot_be_written_changes_no_verdict(tmp_path: Path, film: Path, shell: str) -> None:
    """Catches: a start that fails without a stream, with the exit code of another answer; the line to the
    process that reads in the place of a closed stream; an answer that is lost with a message."""
    done = verify(tmp_path, film, shell=shell)
    assert (done.returncode, done.stderr.decode().splitlines()[1:]) == (0, [])
    assert ">&-" in shell.split() or done.stdout.startswith(b"ACCEPT")


def test_a_film_may_have_a_name_that_is_no_text(tmp_path: Path, film: Path) -> None:
    """Catches: an answer that its reader refuses, for the bytes in the film's name."""
    named = os.fsencode(tmp_path) + b"/f\xff.mp4"
    Path(os.fsdecode(named)).write_bytes(film.read_bytes())
    done = verify(tmp_path, named)
    assert done.returncode == 0, done.stderr
    Path(os.fsdecode(named)).write_bytes(b"no film")
    done = verify(tmp_path, named)
    assert (done.returncode, b"in a stranger" in done.stderr, b"cannot be read" in done.stderr) == (2, False, True)


def test_an_interrupt_shows_no_traceback(tmp_path: Path, film: Path) -> None:
    """Catches: an interrupt that shows lines of Python while packages are loaded, or while the film is read; one that
    ends nothing."""
    (script := tmp_path / "moireid").write_text(PROGRAM)
    words, codes = [sys.executable, script, "verify", film, "--badge", FILMS / "badge.json"], []
    for after_s in (0.0, 0.2, 0.6):
        with subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as program:
            until = time.monotonic() + 30
            # The process from which the one that reads the film is forked.
            while not psutil.Process(program.pid).children():
                assert time.monotonic() < until
                time.sleep(0.005)
            time.sleep(after_s)
            program.send_signal(signal.SIGINT)
            said = program.communicate(timeout=60)[1]
        assert b"Traceback" not in said
        codes.append(program.returncode)
    # A busy machine may have a verdict by then.
    assert {*codes} & {-signal.SIGINT, 130} and {*codes} <= {0, -signal.SIGINT, 130}
