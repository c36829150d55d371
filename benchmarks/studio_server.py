"""A studio that is started by its command, with a registry, films of a badge, and tokens; for the other scripts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil
from hostile_files import spoilt_from

from moireid.badge import load_badge
from moireid.registry import open_registry
from moireid_studio.auth.tokens import open_tokens

COMMAND = "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"


@dataclass(frozen=True)
class StudioServer:
    """Where it answers, tokens of verifiers, its process and log, and films of the badge that it knows."""

    home: str
    tokens: list[str]
    process: psutil.Process
    log: Path
    films: Path


@contextmanager
def served(folder: Path, *options: str, verifiers: int = 1, open_files: int | None = None) -> Iterator[StudioServer]:
    """A studio in whose registry one badge is; open_files: as most systems allow, None for this one's limit."""
    os.environ["MOIREID_KEYS"] = str(folder / "keys")
    url, log, films = f"sqlite:///{folder}/registry.sqlite3", folder / "log", folder / "films"
    films.mkdir()
    spoilt_from(films)
    with open_registry(url, create=True) as registry:
        registry.enroll(load_badge(films / "badge.json"))
    with open_tokens(folder / "studio") as tokens:
        secrets = [tokens.create("verifier")[0] for _ in range(verifiers)]
    command = [
        sys.executable,
        "-c",
        COMMAND,
        "serve",
        "--port",
        "0",
        "--registry",
        url,
        "--data",
        str(folder / "studio"),
    ]
    if open_files is not None:
        command = ["sh", "-c", f'ulimit -Sn {open_files}; exec "$@"', "sh", *command]
    with log.open("wb") as stream, subprocess.Popen([*command, *options], stderr=stream) as server:
        while b"http://" not in (said := log.read_bytes()):
            time.sleep(0.1)
        home = "http://" + said.split(b"http://")[1].split()[0].decode().rstrip("/")
        try:
            yield StudioServer(home, secrets, psutil.Process(server.pid), log, films)
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(60)
