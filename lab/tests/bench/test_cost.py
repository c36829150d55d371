"""What `moireid lab cost` compares."""

from __future__ import annotations

import pytest

from moireid.errors import MoireIdError
from moireid_lab.bench import cost


def test_processor_time_counts_a_program_and_what_it_waits_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: the time of the process alone, where a film is read in one of its own; a program that failed."""
    burn = "import time\nend = time.process_time() + 0.2\nwhile time.process_time() < end: pass"
    child = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {burn!r}], check=True)"
    assert cost._cpu_s(child, [], 1) >= 0.2
    with pytest.raises(MoireIdError, match="ended with 3"):
        cost._cpu_s("import sys; sys.exit(3)", [], 1)
