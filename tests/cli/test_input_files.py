"""Small files that a user names: pipes and endless files are refused at once.  Each test names what it would catch."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import FILMS
from moireid.badge import load_badge
from moireid.files import MOST_SMALL_BYTES, open_regular, read_regular

BADGE = str(FILMS / "badge.json")
FILM = str(FILMS / "genuine_1.0m.mp4")
#: A command for each option that names a file; IT is the file's name.
COMMANDS = {
    "verify --badge": ["verify", FILM, "--badge", "IT"],
    "verify VIDEO": ["verify", "IT", "--badge", BADGE],
    "verify --camera": ["verify", FILM, "--badge", BADGE, "--camera", "IT"],
    "verify --bundle": ["verify", FILM, "--claim", "Ada", "--bundle", "IT"],
    "verify --sign": ["verify", FILM, "--badge", BADGE, "--sign", "IT", "--attest", "v.json"],
    "attest check FILE": ["attest", "check", "IT"],
    "attest check --key": ["attest", "check", BADGE, "--key", "IT"],
    "attest check --film": ["attest", "check", BADGE, "--film", "IT"],
    "attest check --authority": ["attest", "check", BADGE, "--authority", "IT"],
    "attest check --certificate-authority": [
        *("attest", "check", BADGE, "--certificate-identity", "Desk", "--certificate-authority", "IT"),
    ],
    "enroll BADGE": ["enroll", "IT"],
    "enroll --capture": ["enroll", BADGE, "--capture", "IT"],
    "print --people": ["print", "--people", "IT", "--out", "out"],
    "print --logo": ["print", "Ada", "--out", "out", "--logo", "IT"],
    "print --portrait": ["print", "Ada", "--out", "out", "--format", "cr80", "--portrait", "IT"],
    "print --template": ["print", "Ada", "--out", "out", "--template", "IT"],
    "print --lens": ["print", "Ada", "--out", "out", "--lens", "IT"],
    "print --printer": ["print", "Ada", "--out", "out", "--printer", "IT"],
    "simulate BADGE": ["simulate", "IT", "--out", "f.mp4"],
    "simulate --motion": ["simulate", BADGE, "--out", "f.mp4", "--motion", "IT"],
    "calibrate --chart": ["calibrate", BADGE, "--chart", "IT", "--out", "lens.json"],
    "calibrate FILM": ["calibrate", "IT", "--camera", "--out", "camera.yaml"],
    "registry import": ["registry", "import", "IT"],
    "registry audit --since": ["registry", "audit", "--since", "IT"],
    "lab film-set PLAN": ["lab", "film-set", "IT", "--out", "out"],
    "lab evaluate MANIFEST": ["lab", "evaluate", "IT", "--out", "out"],
}
NAMES = {
    "print --people": "it.csv",
    "print --logo": "it.png",
    "print --portrait": "it.png",
    "print --template": "it.toml",
    "print --lens": "it.json",
    "simulate --motion": "it.csv",
    "lab film-set PLAN": "it.csv",
    "lab evaluate MANIFEST": "it.csv",
}
#: Run one after the other in one process, with an alarm, as each start costs a second.
RUN = """
import json, signal, sys
from click.testing import CliRunner
from moireid.cli.main import moireid

def late(number, frame):
    raise SystemExit("waits")

signal.signal(signal.SIGALRM, late)
for name, words in json.loads(sys.argv[1]).items():
    signal.alarm(20)
    done = CliRunner().invoke(moireid, words)
    signal.alarm(0)
    print(json.dumps([name, done.exit_code if done.exception is None or done.exit_code else 1, done.output]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pipe", "endless"])
def test_a_pipe_or_an_endless_file_is_refused_at_once(tmp_path: Path, kind: str) -> None:
    """Catches: an option whose file is waited for without an end, or read whole whatever its size."""
    commands = {}
    for name, words in COMMANDS.items():
        path = tmp_path / NAMES.get(name, "it")
        if not path.exists():
            if kind == "pipe":
                os.mkfifo(path)
            else:
                # A sparse file: 200 GB that take no room.
                with path.open("wb") as file:
                    file.truncate(200 << 30)
        commands[name] = [str(path) if word == "IT" else word for word in words]
    if kind == "endless":
        # These are read as long as they are, and no further than they are understood.
        for name in ("verify VIDEO", "attest check --film", "enroll --capture", "calibrate FILM"):
            del commands[name]
    limit = "import resource; resource.setrlimit(resource.RLIMIT_DATA, (4 << 30, 4 << 30))\n"
    environment = os.environ | {"MOIREID_KEYS": str(tmp_path / "keys"), "MOIREID_SEEN": str(tmp_path / "seen.sqlite3")}
    environment["MOIREID_REGISTRY"] = f"sqlite:///{tmp_path}/people.sqlite3"
    done = subprocess.run(
        [sys.executable, "-c", limit + RUN, json.dumps(commands)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found = [json.loads(line) for line in done.stdout.splitlines()]
    wrong = [(name, code, words[-300:]) for name, code, words in found if code not in (1, 2) or "inside" in words]
    wrong += [(name, code, words) for name, code, words in found if code == 1 and "attest check" not in name]
    wrong += [(name, code, words) for name, code, words in found if "memory" in words or "waits" in words]
    assert not wrong and len(found) == len(commands)


def test_a_small_file_is_read_whole_or_refused(tmp_path: Path) -> None:
    """Catches: a file of which a part is read and taken for the whole; a limit that refuses a file of its own size."""
    (tmp_path / "file").write_bytes(bytes(1000))
    assert len(read_regular(tmp_path / "file", 1000)) == 1000 < MOST_SMALL_BYTES
    with pytest.raises(OSError, match=r"larger than 0\.999 kB"):
        read_regular(tmp_path / "file", 999)
    for path in (tmp_path, Path("/dev/null"), tmp_path / "none"):
        with pytest.raises(OSError, match=r"regular|directory|No such"):
            open_regular(path)


def test_a_badge_in_any_unicode_is_read(tmp_path: Path) -> None:
    """Catches: a badge.json refused as an editor saved it with a byte order mark, or as UTF-16."""
    text = Path(BADGE).read_text(encoding="utf-8")
    for encoding in ("utf-8-sig", "utf-16"):
        (tmp_path / "badge.json").write_text(text, encoding=encoding)
        assert load_badge(tmp_path / "badge.json") == load_badge(BADGE)
