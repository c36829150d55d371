"""The golden rows: what the verifier says of a fixed corpus of films, by the signals that are kept of each.

`benchmarks/golden.py` says how films, rows and signals are made.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from kit.places import FILMS, ROOT

ROWS = ROOT / "benchmarks" / "golden.csv"


@pytest.fixture
def golden(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import golden

    return golden


@pytest.mark.claim("No verdict of the golden films moves unseen")
def test_no_verdict_and_no_finding_moves(golden: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Catches: a change of the judge that was meant to change no verdict, and does; a film that is no longer judged."""
    assert golden.main(["--signals", "--against", str(ROWS)]) == 0, capsys.readouterr().out
    cases = {row["case"] for row in golden.read_rows(ROWS)}
    assert {path.stem for path in golden.SIGNALS.glob("*.signals")} == cases


def test_what_moves_is_printed_and_a_verdict_counts(golden: Any) -> None:
    """Catches: rows of one version compared with themselves; a film that is another one counted as moved."""
    rows = golden.read_rows(ROWS)
    first, second, third, fourth = [row for row in rows if row["verdict"] == "accept"][:4]
    new = [
        first | {"verdict": "reject"},
        second | {"codes": second["codes"].replace("gain:pass", "gain:fail")},
        third | {"gain": str(float(third["gain"]) + 2e-6)},
        fourth | {"luma": "0", "verdict": "reject"},
    ]
    found = list(golden.moved(rows, new, 1e-6, 1e-3))
    assert [counts for counts, _ in found] == [True, True, False, False]
    for words, (_, line) in zip(
        ("accept -> reject", "-gain:pass +gain:fail", "gain", "another film"), found, strict=True
    ):
        assert words in line
    assert list(golden.moved(rows, [third | {"gain": str(float(third["gain"]) + 5e-7)}], 1e-6, 1e-3)) == []


def test_a_film_and_what_is_kept_of_it_give_the_golden_row(golden: Any, tmp_path: Path) -> None:
    """Catches: signals that are kept without what a verdict, a figure or a headline rests on."""
    name = "genuine_2.0m"
    shutil.copyfile(FILMS / f"{name}.mp4", tmp_path / f"data-{name}.mp4")
    shutil.copyfile(FILMS / "badge.json", tmp_path / f"data-{name}.json")
    row = golden.of_film(tmp_path / f"data-{name}.mp4", tmp_path)
    assert golden.of_signals(tmp_path / f"data-{name}.signals") == row
    (old,) = (row for row in golden.read_rows(ROWS) if row["case"] == f"data-{name}")
    assert not any(counts for counts, _ in golden.moved([old], [row], 1e-6, 1e-3)) and old["luma"] == row["luma"]
