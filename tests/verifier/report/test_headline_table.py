"""The headline of every forgery of `simulate --forge` names what was forged.

By `moireid lab bench headlines`, on signals of its films, which are kept in `tests/data/headlines`.
"""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from moireid.simulate.forgeries.trajectories import KINDS
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import headline_of

TESTS = Path(__file__).parents[2]
FILMS = sorted((TESTS / "data" / "headlines").glob("*.npz"))


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(TESTS.parent / "benchmarks"))
    import headlines

    return headlines


@pytest.mark.parametrize("film", FILMS, ids=lambda film: film.stem)
def test_no_headline_misleads(film: Path, table: Any) -> None:
    """Catches: fringes that rest called late; parts that move apart called late; a motion of its own without a size;
    a finding with other words than the headline's."""
    document = table.judged(film.read_bytes())
    row = table.row_of(table.cases()[film.stem], document)
    assert row["judged"] == "right", row
    words = row["headline"].partition("do not follow the law: they ")[2]
    assert any(f"Fringes that {words} explain" in one["text"] for one in document["reasons"]) == bool(words)
    if "differ from the law" in row["headline"]:
        assert " of its motion (most from " in row["headline"] or " times its motion (most from " in row["headline"]
    assert row["kind"] != "true" or row["verdict"] == "accept"


def test_each_forgery_is_there_on_two_motions(table: Any) -> None:
    """Catches: a kind that is added, and whose headline nobody reads; a judgement that calls everything right."""
    found = {(kind, motion) for kind, motion, *_ in (table.cases()[film.stem] for film in FILMS)}
    assert all(sum(kind == one for one, _ in found) >= 2 for kind in ("true", *KINDS))
    assert set(table.CAUSES) == {"true", *KINDS}
    late, half = "The fringes do not follow the law: they come late", "they move half as far as they should"
    assert table.is_right("late", "reject", late) and table.is_right("gain_low", "reject", half)
    for kind, title in (("frozen", late), ("patchy", late), ("gain_high", half), ("late", "Genuine"), ("true", late)):
        assert not table.is_right(kind, "reject", title), kind
    assert not table.is_right("drift", "reject", "Not accepted") and table.is_right("drift", "inconclusive", "Cannot")


@pytest.mark.slow
def test_kept_signals_give_the_headline_of_their_film(table: Any) -> None:
    """Catches: signals that are kept without what the headline rests on."""
    for name in ("frozen_sway_0.6_0", "patchy_sway_0.6_0"):
        report = table.reported(table.cases()[name])
        whole = headline_of(report.to_json(), Circumstances(datetime.now(UTC)))
        again = headline_of(table.judged(table.stored(report)), Circumstances(datetime.now(UTC)))
        assert again == whole and report.verdict == "reject"
