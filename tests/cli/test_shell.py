"""What a terminal gets that a pipe does not: colours, short help, completion."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from kit.coded_films import first_frames
from kit.places import FILMS

PROGRAMS = Path(sys.executable).parent
ESCAPE = b"\x1b["


@pytest.mark.parametrize("program", ["moireid", "print-your-badge"])
def test_h_is_help_in_both_programs(program: str) -> None:
    """Catches: `print-your-badge -h`, of which only --help was known."""
    asked = ([PROGRAMS / program, word] for word in ("-h", "--help"))
    short, long = (subprocess.run(words, capture_output=True, text=True, timeout=60) for words in asked)
    assert short.returncode == 0 and short.stdout == long.stdout and f"Usage: {program}" in short.stdout


def on_terminal(command: list[str], environment: dict[str, str]) -> bytes:
    """What a command writes to a terminal."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(command, stdout=theirs, stderr=subprocess.DEVNULL, env=environment)
    os.close(theirs)
    shown = b""
    # A terminal that was hung up is an error of reading on Linux.
    try:
        while part := os.read(ours, 4096):
            shown += part
    except OSError:
        pass
    os.close(ours)
    process.wait(timeout=60)
    return shown


def test_a_verdict_is_coloured_on_a_terminal_alone(tmp_path: Path) -> None:
    """Catches: escapes in a file or a pipe; colour where NO_COLOR is set; none on a terminal."""
    film = first_frames(FILMS / "genuine_1.0m.mp4", tmp_path / "a.mp4", 45)
    command = [str(PROGRAMS / "moireid"), "verify", str(film), "--badge", str(FILMS / "badge.json")]
    plain = {name: value for name, value in os.environ.items() if name != "NO_COLOR"} | {"TERM": "xterm"}
    shown = on_terminal(command, plain)
    assert shown.startswith(b"\x1b[33m\x1b[1mINCONCLUSIVE\x1b[0m: ") and b"  ?\x1b[0m Of 45 frames" in shown
    assert ESCAPE not in on_terminal(command, plain | {"NO_COLOR": "1"})
    piped = subprocess.run(command, capture_output=True, env=plain, timeout=60)
    assert piped.returncode == 3 and piped.stdout.startswith(b"INCONCLUSIVE: ") and ESCAPE not in piped.stdout


@pytest.mark.parametrize(
    ("program", "line", "expected"),
    [
        ("moireid", "moireid ver", {"verify"}),
        ("moireid", "moireid registry sus", {"suspend"}),
        ("moireid", "moireid print --pap", {"--paper"}),
        ("print-your-badge", "print-your-badge --paper l", {"letter"}),
    ],
)
def test_bash_completes_as_the_guide_sets_it_up(program: str, line: str, expected: set[str]) -> None:
    """Catches: a guide whose line for the shell's start file completes nothing."""
    bash = shutil.which("bash")
    assert bash is not None
    guide = (Path(__file__).parents[2] / "docs" / "reference" / "settings.md").read_text(encoding="utf-8")
    (setting_up,) = (row for row in guide.splitlines() if row.endswith(f'bash_source {program})"'))
    words = line.split()
    script = (
        f"{setting_up}\nCOMP_WORDS=({' '.join(words)})\nCOMP_CWORD={len(words) - 1}\n"
        f"_{program.replace('-', '_')}_completion {program}\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n"
    )
    environment = os.environ | {"PATH": f"{PROGRAMS}:{os.environ['PATH']}"}
    done = subprocess.run([bash, "-c", script], capture_output=True, text=True, timeout=60, env=environment)
    assert set(done.stdout.split()) == expected, done.stderr
