"""What the tests of pages share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture
def pictures(tmp_path: Path) -> Path:
    """Where pictures of the page go: where MOIREID_SCREENSHOTS says, or to the test's own folder."""
    folder = Path(os.environ.get("MOIREID_SCREENSHOTS", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    return folder
