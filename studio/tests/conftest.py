"""A studio for a file of tests."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from kit.webbing import OpenStudio, studio


@pytest.fixture(scope="module")
def open_studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpenStudio]:
    """Open the file's studio, with the badges and settings that it names, in a folder and with keys of its own."""
    folder = tmp_path_factory.mktemp("studio")
    with pytest.MonkeyPatch.context() as patch, ExitStack() as opened:
        patch.setenv("MOIREID_KEYS", str(folder / "keys"))
        yield lambda *badges, **settings: opened.enter_context(studio(folder, *badges, **settings))
