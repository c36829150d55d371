"""What is given to a public function is compared with its annotations, before any work."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import moireid as mo
from moireid.arguments import check_values

FILMS = Path(__file__).parent / "data" / "films"
BADGE = FILMS / "badge.json"
WRONG: list[tuple[Callable[..., Any], dict[str, Any], str]] = [
    (mo.design, {"name": None}, "name=None is not possible; give text"),
    (mo.design, {"name": "A", "axes": "z"}, "axes='z' is not possible; give x, xy or hex"),
    (mo.design, {"name": "A", "lines": "Reporter"}, "lines='Reporter' is not possible; give a list, each entry text"),
    (mo.design, {"name": "A", "lens_thickness_mm": True}, "lens_thickness_mm=True is not possible; give a number"),
    (mo.design, {"name": "A", "colr": "teal"}, r"an order has no field colr \(did you mean colour"),
    (
        mo.print_badge,
        {"badge": None, "folder": "x"},
        "badge=None is not possible; give a Badge, text or a pathlib.Path",
    ),
    (mo.print_badge, {"badge": BADGE, "folder": "x", "mount": "nope"}, "give lanyard, clip, stand or none"),
    (mo.print_badge, {"badge": BADGE, "folder": "x", "measured_scale": (2, 1)}, "give 0.95 to 1.05"),
    (mo.print_badge, {"badge": BADGE, "folder": ""}, "the path is empty"),
    (mo.simulate, {"badge": BADGE, "video": "x.mp4", "distance_m": float("nan")}, "distance_m=nan is not possible"),
    (mo.simulate, {"badge": BADGE, "video": "x.mp4", "frames": 2.5}, "give a whole number"),
    (mo.simulate, {"badge": BADGE, "video": "/not-there/x.mp4"}, "folder /not-there is not there; make it first"),
    (mo.verify, {"film": "x.mp4", "badge": BADGE, "level": "best"}, "give record, enrolled or live"),
    (mo.verify, {"film": "x.mp4", "badge": BADGE, "cover": 2}, "cover=2 is not possible; give 0 to 1"),
    (mo.verify, {"film": "x.mp4", "badge": BADGE, "camera": -5}, "camera=-5 is no focal length"),
    (mo.identify, {"film": 5}, "film=5 is not possible"),
    (mo.mount_solids, {"badge": None}, "badge=None is not possible; give a Badge"),
]


@pytest.mark.parametrize(("function", "given", "words"), WRONG)
def test_what_does_not_fit_is_named_with_what_would(
    function: Callable[..., Any], given: dict[str, Any], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: an error of the inside (TypeError, AttributeError); a value that is taken for another without a word; a
    folder that is made although nothing can be done; a word of the command line."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(mo.SpecError, match=words) as refused:
        function(**given)
    assert "--" not in str(refused.value) and not list(tmp_path.iterdir()) and not Path("/not-there").exists()


def test_a_warning_is_of_the_line_that_calls(tmp_path: Path) -> None:
    """Catches: warnings of a line inside the library, which Python shows once for all badges."""
    with pytest.warns(UserWarning, match="nothing in colour") as warned:
        mo.print_badge(mo.load_badge(BADGE), tmp_path / "a", mount="none", template="plain", colour="teal")
    assert warned[0].filename == __file__


def test_what_fits_is_let_through() -> None:
    """Catches: a number that numpy made, or a list in place of a tuple, refused."""
    import numpy as np

    check_values(mo.Order, {"size_mm": [1, np.float64(2)], "printer_dpi": np.int64(600), "payload": None}, {})
