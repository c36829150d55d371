"""Which seconds were judged, as bars over the film's own time and in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from moireid.verifier.timeline import Span, outside, within

#: Colours of the verdicts, and what each means in the law's bar.
BANDS = {"accept": "#1c7c4a", "reject": "#b3261e", "inconclusive": "#9aa4b0"}
LAW = {"accept": "the law holds", "reject": "the law is broken", "inconclusive": "too little to decide"}
#: A shorter time without verdict is not named, and at most MOST_NAMED of them are.
LEAST_GAP_S, MOST_NAMED = 0.5, 3
#: From this share on, a film counts as judged completely.
WHOLE = 0.995


#: A part of a row: from and width as shares of the film, 0 to 100, and what it shows.
Bar = tuple[float, float, str]


@dataclass(frozen=True)
class Seconds:
    """Rows of bars by their label, the film's end in s, the meanings of the kinds that occur, and a sentence."""

    rows: tuple[tuple[str, tuple[Bar, ...]], ...]
    end: str
    kinds: tuple[tuple[str, str], ...]
    text: str


def seconds_of(document: Mapping[str, Any]) -> Seconds | None:
    """The seconds of a report, as in its JSON; None if it does not state them."""
    cover = document.get("cover")
    if not cover or not cover.get("film_s") or cover["film_s"][1] <= cover["film_s"][0]:
        return None
    film = (float(cover["film_s"][0]), float(cover["film_s"][1]))
    seen, judged = _spans(cover["seen_s"]), _spans(cover["spans_s"])
    rows = [
        ("badge seen", _bars(film, seen, "seen")),
        ("judged", _bars(film, judged, "judged")),
        ("the law", _law_bars(film, document["segments"], seen)),
    ]
    if overlap := document.get("overlap"):
        rows += [
            ("face seen", _bars(film, _spans(overlap["faces"]), "seen")),
            ("badge before it", _bars(film, _spans(overlap["overlaps"]), "judged")),
        ]
    kinds = tuple((kind, LAW[kind]) for kind in LAW if any(shown == kind for _, bars in rows for *_, shown in bars))
    return Seconds(tuple(rows), f"{film[1] - film[0]:.1f} s", kinds, _words(film, seen, judged, cover["share"]))


def _spans(said: Iterable[Sequence[float]]) -> tuple[Span, ...]:
    return tuple((float(start), float(end)) for start, end in said)


def _bars(film: Span, spans: Sequence[Span], kind: str) -> tuple[Bar, ...]:
    long = film[1] - film[0]
    found: list[Bar] = []
    for start, end in spans:
        at, to = (100 * min(max((time_s - film[0]) / long, 0.0), 1.0) for time_s in (start, end))
        # A moment is shown as a thin line.
        found.append((min(at, 99.5), max(to - at, 0.5), kind))
    return tuple(found)


def _law_bars(film: Span, segments: Sequence[Mapping[str, Any]], seen: Sequence[Span]) -> tuple[Bar, ...]:
    """The verdict on each few seconds, for the time in which the badge was seen."""
    return tuple(
        bar
        for segment in segments
        for bar in _bars(film, within((segment["start_s"], segment["end_s"]), seen), segment["verdict"])
    )


def _words(film: Span, seen: Sequence[Span], judged: Sequence[Span], share: float) -> str:
    """How much was judged, and the longest gaps."""
    if not seen:
        return f"The badge was not followed anywhere in this film of {film[1] - film[0]:.1f} s."
    if not judged:
        shown = sum(end - start for start, end in seen)
        return f"The badge is seen in {shown:.1f} of {film[1] - film[0]:.1f} s, and none of them could be judged."
    text = f"The verdict covers {100 * share:.0f} % of the film's {film[1] - film[0]:.1f} s."
    gaps = [gap for gap in outside(film, judged) if gap[1] - gap[0] >= LEAST_GAP_S]
    if not gaps:
        return f"{text} {'No part' if share >= WHOLE else 'No more than a moment'} of it is left out."
    longest = sorted(sorted(gaps, key=lambda gap: gap[0] - gap[1])[:MOST_NAMED])
    named = ", ".join(f"{start:.1f} to {end:.1f} s" for start, end in longest)
    more = " and more" if len(gaps) > MOST_NAMED else ""
    return f"{text} It does not cover {named}{more}."
