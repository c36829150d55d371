"""A user without an entry in passwd and without HOME, as in many containers.  Each test names what it catches."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from kit.coded_films import first_frames
from kit.places import FILMS

#: As the system answers for a user of whom it knows only the number; libraries that are loaded later ask it too.
PROGRAM = """
import pwd, sys
def unknown(number):
    raise KeyError(number)
pwd.getpwuid = unknown
from moireid.cli.main import main
main()
"""
BADGE = str(FILMS / "badge.json")


def run(folder: Path, *words: object, **variables: str) -> subprocess.CompletedProcess[str]:
    """`moireid`, as that user runs it."""
    closed = {name: value for name, value in os.environ.items() if not name.startswith(("HOME", "XDG_", "MOIREID_"))}
    command = [sys.executable, "-c", PROGRAM, *map(str, words)]
    return subprocess.run(
        command, cwd=folder, env=closed | variables, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.parametrize(
    ("words", "helps"),
    [
        ("registry list", "give --registry, or set MOIREID_REGISTRY"),
        ("verify film.mp4 --claim Ada", "give --registry, or set MOIREID_REGISTRY"),
        ("registry list --registry ~/people.sqlite3", "give the whole path"),
        ("registry init --registry people.sqlite3", "set MOIREID_KEYS"),
        ("token list", "name a folder (--data)"),
    ],
)
def test_where_a_home_is_needed_a_sentence_says_what_to_give(tmp_path: Path, words: str, helps: str) -> None:
    """Catches: a traceback; "something went wrong inside moireid"; a folder named `~` in the working folder."""
    done = run(tmp_path, *words.split())
    assert (done.returncode, done.stdout, len(done.stderr.splitlines())) == (2, "", 1)
    assert done.stderr.startswith("error: ") and helps in done.stderr and "inside moireid" not in done.stderr
    assert {path.name for path in tmp_path.iterdir()} <= {"people.sqlite3"}


@pytest.mark.slow
def test_what_needs_no_home_works(tmp_path: Path) -> None:
    """Catches: a default that is looked up although nothing of it is used, also by a process that reads films."""
    film = first_frames(FILMS / "genuine_1.0m.mp4", tmp_path / "film.mp4", 100)
    done = run(tmp_path, "verify", film, "--badge", BADGE)
    assert done.returncode == 0, done.stderr
    for words in (
        "print Bob --out bob --mount none",
        "pitch-test --out chart",
        "materials --format a6 --people 3 --out list",
    ):
        done = run(tmp_path, *words.split())
        assert done.returncode == 0, done.stderr
