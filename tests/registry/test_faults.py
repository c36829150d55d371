"""Whatever call of files or of PostgreSQL fails, and whenever the power is cut, the state is of before or of after.

Points are drawn with a fixed seed, so that each kind of call fails in each way.  All points, each in an hour or less:
`cd tests && python -m kit.fault_runs /dev/shm 0`, `kit.fault_runs_postgres /dev/shm 0`, `kit.power_cuts /dev/shm 0`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from kit.fault_runs import KINDS, OPERATIONS
from kit.places import TESTS
from kit.registries import Server

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="file calls are made to fail by LD_PRELOAD")


#: The calls of files, as faults.c names them, that change something; and the changes of a file, as it writes them down.
CALLS = {"open", "write", "pwrite", "fsync", "rename", "unlink", "mkdir"}
CHANGES = set("OWRUMS")


def faulty(place: Path, most: int, *names: str, module: str = "fault_runs") -> tuple[int, set[tuple[str, str]]]:
    """How many points were tried, all of which must hold; and which calls failed in which way."""
    command = [sys.executable, "-m", f"kit.{module}", str(place), str(most), *names]
    done = subprocess.run(command, cwd=TESTS, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout)
    assert found["wrong"] == [], "\n".join(found["wrong"][:5])
    return int(found["points"]), {(way, call) for way, call in found["covered"]}


@pytest.mark.slow
def test_every_operation_survives_failing_file_calls(tmp_path: Path) -> None:
    """Catches: a revocation that is said to be done and is not, a memory that is ahead of its registry, half a bundle,
    an error of the database that no one translates, a key that is gone, an import that is half done.
    """
    tried, covered = faulty(tmp_path, 4)
    assert tried >= 4 * len(OPERATIONS) and {(way, call) for way in KINDS for call in CALLS} <= covered


@pytest.mark.slow
def test_a_failing_file_call_leaves_before_or_after(tmp_path: Path) -> None:
    """Catches: as above, of a checkpoint: its name on the disk before its bytes."""
    assert faulty(tmp_path, 1, "checkpoint")[0] >= 20


@pytest.mark.slow
def test_every_operation_survives_power_cuts(tmp_path: Path) -> None:
    """Catches: a revocation that was done and is gone; a memory that is ahead of its registry; a key that is lost."""
    tried, covered = faulty(tmp_path, 4, module="power_cuts")
    assert tried >= 4 * len(OPERATIONS) and {call for _, call in covered} == CHANGES


@pytest.mark.slow
def test_every_operation_survives_failing_calls_of_postgresql(tmp_path: Path, postgres: Server) -> None:
    """Catches: an error of the driver that no one translates; a change that is said to be done after a lost commit; a
    key that is deleted although its registry had reached the server.

    The server of the tests is only asked for so that this is skipped where there is none.
    """
    tried, covered = faulty(tmp_path, 4, module="fault_runs_postgres")
    assert tried >= 4 * len(OPERATIONS) and len(covered) == 4 * 3
