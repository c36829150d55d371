"""The headline of every forgery of `simulate --forge` names what was forged.

On the signals that are kept of the forged golden films, and of the true ones among them (`tests/data/golden`).  A
headline is misleading if it names a cause that is not among those that are true of the kind (`CAUSES`), whatever the
verdict.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from typing import Any

import pytest

from kit.places import ROOT, TESTS
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import BROKEN, headline_of

#: By the simulator, which forges in each of its ways.
FILMS = sorted(set((GOLDEN := TESTS / "data" / "golden").glob("forged-*.signals")) - set(GOLDEN.glob("forged-real-*")))
#: The cause that a headline names, by words of it, of today and of before.
NAMED = {
    "still": "stay still|hardly move|still picture",
    "other way": "other way",
    "less far": "only 0.[0-9]+ times as far|half as far",
    "farther": "move ([1-9][0-9.]* times|twice) as far",
    "drift": "drift at",
    "late": "come (late|early|[0-9.]+ s (late|early))",
    "place": "badge's place",
    "own motion": "by themselves|do not go with",
    "parts": "move apart|row to row|place to place",
    "spell": "(leave the law|leave it) (from|for a while)",
    "differ": "differ from the law|leave it, as|leave the law, perhaps|wander on top",
    "genuine": "^Genuine",
    "another badge": "^Another|^Several|two badges|but another|A copy",
    "film": "frames are mixed|zoomed|covers the badge|looks stretched",
}
#: What each forgery does, and so what a headline may name.  `differ` says by how much and when, and blames nothing; it
#: is too little where the gain alone is false, or the fringes rest.
CAUSES = {
    "true": ("genuine",),
    "frozen": ("still",),
    "photo": ("still",),
    "drift": ("drift", "differ"),
    "randomwalk": ("own motion", "differ", "spell"),
    "late": ("late", "differ"),
    "gain_low": ("less far",),
    "gain_high": ("farther",),
    "reversed": ("other way",),
    "splice": ("own motion", "differ", "spell"),
    "wobble": ("own motion", "differ", "spell"),
    "patchy": ("parts", "differ"),
    "generative": ("parts", "own motion", "differ"),
    "screen": ("own motion", "differ", "spell"),
}


def cause_named(title: str) -> str | None:
    """The cause that a headline names; None where it names none, as of a film that shows too little."""
    if title.endswith("would look the same"):
        return None
    return next((cause for cause, words in NAMED.items() if re.search(words, title)), None)


def is_right(kind: str, verdict: str, title: str) -> bool:
    """Whether the headline misleads no one about this kind; one that rejects must name a cause."""
    cause = cause_named(title)
    return cause in CAUSES[kind] or (cause is None and verdict == "inconclusive")


def test_no_headline_misleads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: fringes that rest called late; parts that move apart called late; a motion of its own without a size;
    a finding with other words than the headline's; a kind that is added, and whose headline nobody reads."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    from golden import KeptFilm

    wrong, kinds = [], list[str]()
    for film in FILMS:
        kind, motion, *_ = film.stem.removeprefix("forged-").rsplit("_", 3)
        document: dict[str, Any] = KeptFilm.from_bytes(film.read_bytes()).report()
        title = headline_of(document, Circumstances(datetime.now(UTC))).title
        kinds.append(kind)
        if not is_right(kind, document["verdict"], title):
            wrong.append(f"{kind} {motion}")
        assert kind != "true" or document["verdict"] != "reject"
        words = title.partition("do not follow the law: they ")[2]
        of_a_rival = bool(words) and words != BROKEN["parts"]
        assert any(f"Fringes that {words} explain" in one["text"] for one in document["reasons"]) == of_a_rival
        if "differ from the law" in title:
            assert " of its motion, most from " in title or " times its motion, most from " in title
    assert not wrong and all(kinds.count(kind) >= 2 for kind in ("true", *KINDS))
