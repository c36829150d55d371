"""Does each headline name what the forger did?  Run `moireid lab bench headlines [--only REGEX]`.

The forged films of the golden rows, and the true ones among them, by the signals that are kept of each
(`golden.py --keep`).  A headline is misleading if it names a cause that is not among those that are true of the kind
(`CAUSES`), whatever the verdict.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from golden import SIGNALS, KeptFilm

from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import headline_of
from moireid_lab.bench.bench_frame import Bench, Row, Wish

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


def judged(film: Path) -> Row:
    """One film of the table, by its kept signals."""
    kind, motion, distance, seed = film.stem.removeprefix("forged-").rsplit("_", 3)
    document = KeptFilm.from_bytes(film.read_bytes()).report()
    title = headline_of(document, Circumstances(datetime.now(UTC))).title
    right = is_right(kind, document["verdict"], title)
    return {
        "kind": kind,
        "motion": motion,
        "distance": float(distance),
        "seed": int(seed),
        "gain": document["invariant"]["gain_ratio"],
        "verdict": document["verdict"],
        "judged": "right" if right else "MISLEADING",
        "headline": title,
        "findings": [reason["text"] for reason in document["reasons"]],
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row for each film."""
    yield from wish.each(judged, {film.stem: film for film in sorted(SIGNALS.glob("forged-*.signals"))})


def notes(found: list[Row]) -> Iterator[str]:
    """How many headlines mislead."""
    wrong = [row for row in found if row["judged"] != "right"]
    yield f"{len(wrong)} of {len(found)} headlines mislead"


BENCH = Bench(
    rows,
    {
        "kind": "<11",
        "motion": "<9",
        "distance": ">8.1f",
        "seed": ">4d",
        "gain": ">7.3f",
        "verdict": "<12",
        "judged": "<11",
        "headline": "<0",
    },
    notes,
)
