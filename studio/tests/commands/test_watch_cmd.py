"""`moireid watch` as it is typed.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from kit.places import FILMS
from kit.streams import pictures, write_stream
from moireid_studio.commands.watch_display import LiveLines, line_of

BADGE = ["--badge", str(FILMS / "badge.json")]
PROGRAM = [str(Path(sys.executable).parent / "moireid"), "watch"]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_stream(tmp_path_factory.mktemp("film") / "film.ts", pictures()).read_bytes()


@pytest.mark.slow
def test_each_event_is_a_line_and_the_exit_code_that_of_the_last(film: bytes, tmp_path: Path) -> None:
    """Catches: lines that come at the end alone; talk among them; an exit code of another verdict."""
    done = subprocess.run([*PROGRAM, "-", *BADGE, "--json"], input=film, capture_output=True, timeout=120, check=False)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0 and lines[0]["event"] == "begun" and lines[-1]["event"] == "verdict"
    assert lines[-1]["verdict"] == "accept" and lines[-1]["claim_source"] == "file" and done.stderr == b""
    forged = write_stream(tmp_path / "forged.ts", pictures("forged_drift_1.0m"))
    done = subprocess.run([*PROGRAM, str(forged), *BADGE], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1 and done.stdout.startswith("REJECT: ")


@pytest.mark.slow
def test_an_interrupt_gives_the_verdict_so_far(film: bytes) -> None:
    """Catches: an interrupt that loses what was seen, or is answered with 130."""
    with subprocess.Popen(
        [*PROGRAM, "-", *BADGE, "--json"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        assert running.stdin is not None and running.stdout is not None and running.stderr is not None
        running.stdin.write(film)
        running.stdin.flush()
        assert json.loads(running.stdout.readline())["event"] == "begun"
        time.sleep(4)
        running.send_signal(signal.SIGINT)
        last = json.loads(running.stdout.read().splitlines()[-1])
        assert running.wait(30) == 0 and last["verdict"] == "accept" and last["end"]["why"] == "asked"
        assert b"Traceback" not in running.stderr.read()


def test_lines_for_people_are_whole_and_harmless(capsys: pytest.CaptureFixture[str]) -> None:
    """Catches: a prompt that is not shown; words of a stranger's stream that steer the terminal."""
    prompt = {"event": "prompt", "number": 2, "of": 6, "move": "left", "text": "Move it 20 cm to your left."}
    assert line_of(prompt) == "2 of 6: Move it 20 cm to your left."
    status = {"event": "status", "verdict": "reject", "badge": True, "tracked": 3}
    show = LiveLines().show
    for reasons in ([{"level": "fail", "text": "first\x1b[2J\nb\x9bc"}], [{"level": "fail", "text": "second"}]):
        show(status | {"reasons": reasons})
    show(status | {"verdict": "accept", "reasons": []})
    lines = capsys.readouterr().err.splitlines()
    assert [line.split("  ")[-1] for line in lines] == [r"reject: first\u001b[2J\nb\u009bc", "accept: "]
