"""What `moireid lab cost` compares."""

from __future__ import annotations

from pathlib import Path

import pytest

from moireid.errors import MoireIdError
from moireid_lab.bench import cost


def test_time_and_memory_are_those_of_a_program_and_of_what_it_waits_for(tmp_path: Path) -> None:
    """Catches: those of the process alone, where a film is read in one of its own; a program that failed."""
    burn = (
        "import time\nheld = b'1' * 80_000_000\nend = time.process_time() + 0.3\nwhile time.process_time() < end: pass"
    )
    child = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {burn!r}], check=True)"
    seconds, mb = cost._run(tmp_path, child, "")
    assert seconds >= 0.3 and mb >= 80
    with pytest.raises(MoireIdError, match="ended with 2"):
        cost._run(tmp_path, "import sys; sys.exit(2)", "")
