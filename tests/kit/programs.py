"""Programs that some tests need and that pip does not install."""

from __future__ import annotations

import shutil

import pytest

#: By the name of the program: the Debian package that holds it.
PACKAGES = {
    "chromium": "chromium",
    "gs": "ghostscript",
    "openssl": "openssl",
    "pdftoppm": "poppler-utils",
    "pdftotext": "poppler-utils",
    "prusa-slicer": "prusa-slicer",
}


def needs(program: str) -> str:
    """The path of a program; without it the test is skipped, which fails the run where CI is set (conftest.py)."""
    path = shutil.which(program)
    if path is None:
        pytest.skip(f"{program} is not installed (Debian: apt-get install {PACKAGES[program]})")
    return path
