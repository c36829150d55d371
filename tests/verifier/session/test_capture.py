"""Captures of one badge: what must agree between them.  Each test states what it would catch."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from moireid.asbuilt import AsBuilt
from moireid.errors import MediaError
from moireid.verifier.session.capture import check_builds

ONE = AsBuilt("7097c67b0fafc59b", -0.0402, 2e-5, 3.0, 0.04, 0.031, 3e-4, 0.72, 0.01)
FILMS = [Path("a.mp4"), Path("b.mp4"), Path("c.mp4")]


def test_films_of_one_sheet_agree_on_its_gain_within_their_error_bars(ada):
    """Catches: any scatter refused; two sheets averaged into a third; only neighbours compared."""
    check_builds([ONE], FILMS[:1], ada)
    check_builds([ONE, replace(ONE, gain_ratio=0.745), replace(ONE, gain_ratio=0.9, gain_sd=0.07)], FILMS, ada)
    with pytest.raises(MediaError, match=r"a\.mp4 and c\.mp4 differ"):
        check_builds([ONE, replace(ONE, gain_ratio=0.745), replace(ONE, gain_ratio=0.79)], FILMS, ada)
