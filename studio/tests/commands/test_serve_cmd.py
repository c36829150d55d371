"""The studio as its command starts it.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import httpx
import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid_studio.commands.serve_cmd import check_sealed

SERVE = "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"


@pytest.mark.claim("serve refuses to read films where nothing seals")
def test_films_of_strangers_are_not_read_where_nothing_seals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a studio that goes on after a note; one of the user's own machine that is refused."""
    monkeypatch.setattr("moireid.sandbox.process.sealed_here", lambda: ("no_new_privileges",))
    done = CliRunner().invoke(moireid, ["serve", "--port", "0", "--data", str(tmp_path)])
    assert done.exit_code == 2 and "films of strangers are not read here" in done.stderr, done.output
    assert "could reach the network" in done.stderr and "--unsealed" in done.stderr
    for allowed in (False, True):
        with pytest.raises(SpecError) if not allowed else nullcontext():
            check_sealed(allowed=allowed)


@pytest.mark.slow
def test_the_studio_starts_in_a_fresh_place(tmp_path: Path) -> None:
    """Catches: a first `moireid serve --no-auth` that asks for a registry, and a second that trips over the first's; a
    studio that keeps quiet about what holds.
    """
    environment = {name: word for name, word in os.environ.items() if not name.startswith("MOIREID_")}
    environment |= {"XDG_DATA_HOME": str(tmp_path / "data"), "HOME": str(tmp_path)}
    command = [sys.executable, "-c", SERVE, "serve", "--no-auth", "--port", "0"]
    for words in ("there was no registry, so a new one was made: sqlite:///", "no one is enrolled yet"):
        with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as server:
            assert server.stderr is not None
            said = server.stderr.readline()
            assert "the studio is at http://" in said, said
            held = server.stderr.readline()
            assert ("reaches no network" in held) == (sys.platform == "linux") and "a film's process" in held
            assert words in server.stderr.readline()
            home = said.split()[4]
            for path in ("", "registry", "verify", "issue"):
                assert httpx.get(home + path, timeout=100).status_code == 200
            server.send_signal(signal.SIGINT)
            assert server.wait(60) == 0
        assert (tmp_path / "data" / "moireid" / "registry.sqlite3").is_file()
