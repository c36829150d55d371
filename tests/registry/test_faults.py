"""Whatever call of files fails, or ends the process, the state is that of before or that of after.

Points are drawn with a fixed seed, so that each kind of call fails in each way.  All points, in an hour or less:
`cd tests && python -m kit.fault_runs /dev/shm 0`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from kit.fault_runs import KINDS, OPERATIONS
from kit.places import TESTS

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="file calls are made to fail by LD_PRELOAD")


#: The calls of files, as faults.c names them, that change something.
CALLS = {"open", "write", "pwrite", "fsync", "rename", "unlink", "mkdir"}


def faulty(place: Path, most: int, *names: str) -> tuple[int, set[tuple[str, str]]]:
    """How many points were tried, all of which must hold; and which calls failed in which way."""
    command = [sys.executable, "-m", "kit.fault_runs", str(place), str(most), *names]
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
