"""Whatever file call fails, the registry and its files are those of before or of after.

All points, in about half an hour: `cd tests && python -m kit.fault_runs /dev/shm 1`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from kit.fault_runs import OPERATIONS
from kit.places import TESTS

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="file calls are made to fail by LD_PRELOAD")


def faulty(place: Path, step: int, *names: str) -> int:
    """How many points were tried, all of which must hold."""
    command = [sys.executable, "-m", "kit.fault_runs", str(place), str(step), *names]
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


def test_a_witness_whose_file_calls_fail_signs_one_log(tmp_path: Path) -> None:
    """Catches: a signature that leaves before its state is on the disk; a state that is torn and cannot be read."""
    assert faulty(tmp_path, 1, "witness") >= 50


@pytest.mark.slow
def test_every_operation_survives_failing_file_calls(tmp_path: Path) -> None:
    """Catches: as above, in every operation that writes: a key that is gone, an import that is half done."""
    tried = sum(faulty(tmp_path, 13, name) for name in OPERATIONS)
    print(f"{tried} points of failure, all sound")  # noqa: T201
    assert tried > 300
