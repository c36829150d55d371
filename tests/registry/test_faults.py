"""Whatever call of files or of PostgreSQL fails, and whenever the power is cut, the state is of before or of after.

All points, each in an hour or less: `cd tests && python -m kit.fault_runs /dev/shm 1`, `python -m
kit.fault_runs_postgres /dev/shm 1`, `python -m kit.power_cuts /dev/shm`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from kit.fault_runs import OPERATIONS
from kit.places import TESTS
from kit.registries import Server

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="file calls are made to fail by LD_PRELOAD")


def faulty(place: Path, *words: object, module: str = "fault_runs") -> int:
    """How many points were tried, all of which must hold."""
    command = [sys.executable, "-m", f"kit.{module}", str(place), *map(str, words)]
    done = subprocess.run(command, cwd=TESTS, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout)
    assert found["wrong"] == [], "\n".join(found["wrong"][:5])
    return int(found["points"])


def test_a_failing_file_call_leaves_before_or_after(tmp_path: Path) -> None:
    """Catches: a revocation that is said to be done and is not, a memory that is ahead of its registry, half a bundle,
    an error of the database that no one translates.
    """
    assert faulty(tmp_path, 29, "revoke", "publish") >= 20


@pytest.mark.slow
def test_every_operation_survives_failing_file_calls(tmp_path: Path) -> None:
    """Catches: as above, in every operation that writes: a key that is gone, an import that is half done."""
    tried = sum(faulty(tmp_path, 13, name) for name in OPERATIONS)
    print(f"{tried} points of failure, all sound")  # noqa: T201
    assert tried > 300


@pytest.mark.claim("A power cut leaves the state of before or after")
def test_a_power_cut_leaves_before_or_after(tmp_path: Path) -> None:
    """Catches: a checkpoint whose name is on the disk before its bytes."""
    assert faulty(tmp_path, "checkpoint", module="power_cuts") >= 100


@pytest.mark.slow
def test_every_operation_survives_power_cuts(tmp_path: Path) -> None:
    """Catches: a revocation that was done and is gone; a memory that is ahead of its registry; a key that is lost."""
    tried = faulty(tmp_path, module="power_cuts")
    print(f"{tried} power cuts, all sound")  # noqa: T201
    assert tried > 3000


def test_a_failing_call_of_postgresql_leaves_before_or_after(tmp_path: Path, postgres: Server) -> None:
    """Catches: an error of the driver that no one translates; a change that is said to be done after a lost commit.

    The server of the tests is only asked for so that this is skipped where there is none.
    """
    assert faulty(tmp_path, 9, "revoke", module="fault_runs_postgres") >= 20


@pytest.mark.slow
def test_every_operation_survives_failing_calls_of_postgresql(tmp_path: Path, postgres: Server) -> None:
    """Catches: as above, in every operation: a key that is deleted although its registry had reached the server."""
    tried = sum(faulty(tmp_path, 9, name, module="fault_runs_postgres") for name in OPERATIONS)
    print(f"{tried} points of failure, all sound")  # noqa: T201
    assert tried > 200
