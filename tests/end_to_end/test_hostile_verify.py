"""Crafted media through plain `verify`, by the command.  Each test names the fault that it catches."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from kit.crafted_media import CRAFTED
from kit.hostile_verify import outcomes


@pytest.mark.claim("No file harms the machine of who verifies it")
@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory, pipes and devices are those of Linux")
def test_no_file_harms_the_machine_of_who_verifies_it(tmp_path: Path) -> None:
    """Catches: a file that opens another one, takes a gigabyte or a minute, or ends in an internal error."""
    found = list(outcomes(tmp_path))
    assert len(found) == len(CRAFTED)
    assert not [(name, faults, outcome) for name, outcome, faults in found if faults]
