"""The scoreboard's tables in README and docs/accuracy.md; `python -m moireid_lab.bench.scoreboard_tables` writes them,
and the paper's curves as a picture.

A table is between `<!-- scoreboard: NAME -->` and `<!-- end -->`; NAME is `readme`, `all`, `parts`, `kinds` with a
part's name, or `paper` with one of `paper_tables.TABLES`.
README shows figures of this version of the sources alone; elsewhere an older figure, shown where a question has none of
this version, says so, with its date.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from moireid.files import write_text
from moireid.result_cache import kept_rows
from moireid_lab.bench.paper_tables import TABLES, roc_figure
from moireid_lab.bench.part import Asked, Row
from moireid_lab.bench.scoreboard import OUTCOMES, ROWS, document_of, newest_rows, plan
from moireid_lab.bench.sources import ROOT
from moireid_lab.evaluation.plots import write_svg

SCOREBOARD = ROOT / "benchmarks" / "scoreboard"
PAGES = (ROOT / "README.md", ROOT / "docs" / "accuracy.md")
ROC = ROOT / "docs" / "gallery" / "roc.svg"
#: What README shows: parts and questions.
README = (
    ("outside", "genuine"),
    ("outside", "forged"),
    ("outside", "identity"),
    ("natural", "genuine"),
    ("natural", "forged"),
    ("lenses", "air"),
    ("builds", "after"),
    ("builds", "copy"),
    ("half-real", "genuine"),
    ("reality", "at 1 m"),
    ("reality", "forged"),
    ("kept", "forged"),
    ("live", "replay"),
    ("morphed", "forged"),
    ("laid-over", "forged"),
    ("replayed", "forged"),
)
#: So many kinds of one film each are named, at most.
MOST_NAMED = 12
_PLACE = re.compile(r"(<!-- scoreboard: ([\w -]+) -->\n).*?(<!-- end -->)", re.DOTALL)
Entry = dict[str, Any]


def with_tables(text: str, document: dict[str, Any]) -> str:
    """A page with its tables."""

    def table(place: re.Match[str]) -> str:
        return "\n".join([place[1].rstrip(), _table(_cells(place[2].split(), document)), place[3]])

    return _PLACE.sub(table, text)


def paper_text(kept: Path) -> str:
    """All tables of the paper's experiments as a page, from a file of rows."""
    own = _paper_rows(kept)
    made = {f"{row['version']} of {row['date']}" for row in own}
    tables = [f"## {name.capitalize()}\n\n{_table(table(own))}\n" for name, table in TABLES.items()]
    return "\n".join([f"# The paper's experiments\n\nVersion of the sources: {', '.join(sorted(made))}.\n", *tables])


def _paper_rows(kept: Path) -> list[Row]:
    return [row for row in kept_rows(kept).values() if row.get("part") == "paper"]


def _table(cells: Iterable[Sequence[str]]) -> str:
    """A table in Markdown, of which the first row is the heading."""
    # A row may end before the heading does; the cells that it lacks are empty.
    rows = [f"| {' | '.join(one).rstrip(' |')} |" for one in cells]
    if len(rows) == 1:
        return "*Nothing of this is measured yet.*"
    return "\n".join([rows[0], "|" + "---|" * (rows[0].count(" | ") + 1), *rows[1:]])


def _cells(name: list[str], document: dict[str, Any]) -> Iterator[Sequence[str]]:
    """The rows of a table, the heading first."""
    found: list[Entry] = document["questions"]
    answered = {(entry["part"], entry["question"]) for entry in found if not entry["older"]}
    questions = [entry for entry in found if not entry["older"] or (entry["part"], entry["question"]) not in answered]
    if name == ["readme"]:
        yield "question", "films by", "films", *OUTCOMES, "right, 95 %"
        by_name = {(entry["part"], entry["question"]): entry for entry in questions}
        for entry in (by_name[one] for one in README if one in answered):
            yield entry["text"], entry["films_by"], *_counts(entry), _interval(entry)
    elif name == ["all"]:
        yield "question", "films by", "films", *OUTCOMES, "right, 95 %"
        made = ""
        for entry in questions:
            before, made = made, f"`{entry['command']}`, version {entry['version']} of {entry['date']}"
            if entry["older"]:
                made += ", which is older"
            if made != before:
                yield (f"*{made}*",)
            yield entry["text"], entry["films_by"], *_counts(entry), _interval(entry)
    elif name == ["parts"]:
        yield "part", "cases", "processor s a case", "hours of two cores"
        for part in document["parts"]:
            hours = part["cases"] * part["s_a_case"] / 7200
            yield f"`{part['part']}`", str(part["cases"]), f"{part['s_a_case']:g}", f"{hours:.2f}"
    elif name[0] == "paper":
        yield from TABLES[name[1]](_paper_rows(SCOREBOARD / ROWS))
    else:
        yield "kind", "films", *OUTCOMES, "what decided the others", "figures, once for the same films"
        yield from _kinds([entry for entry in questions if entry["part"] == name[1]])


def _kinds(questions: Sequence[Entry]) -> Iterator[Sequence[str]]:
    """The rows of a part's kinds of films, question by question; figures that were shown for a kind are not repeated.

    Convention: a question of which all is right, with no new figures, is in the table of all questions alone.  Kinds of
        one film each that are all right, or all inconclusive, are one row; the latter are named if they are few.  Each
        kind that is wrong has a row of its own.
    """
    shown: dict[str, dict[str, Any]] = {}
    for entry in questions:
        kinds: list[Entry] = entry["kinds"]
        title = f"*{entry['text']}*" + (f" (older, of {entry['date']})" if entry["older"] else "")
        known = all(shown.get(kind["kind"], {}) == kind["figures"] for kind in kinds)
        if known and entry["films"] == entry["right"]:
            continue
        several = len(kinds) > 1
        if several:
            yield (title,)
        for outcome in OUTCOMES[:2]:
            single = [kind for kind in kinds if kind["films"] == kind[outcome] == 1]
            if several and len(single) > 2:
                kinds = [kind for kind in kinds if kind not in single]
                codes = Counter(code for kind in single for code in kind["why"].split(", ") if code)
                decided = "" if outcome == "right" else ", ".join(code for code, _ in codes.most_common(3))
                counts = (str(len(single) if one == outcome else 0) for one in OUTCOMES)
                names = "" if outcome == "right" or len(single) > MOST_NAMED else "; ".join(k["kind"] for k in single)
                yield f"kinds of one film each{': ' * bool(names)}{names}", str(len(single)), *counts, decided, ""
        for kind in kinds:
            own = kind["figures"]
            new = {} if shown.get(kind["kind"]) == own else own
            figures = (f"{key} {low:g}{f' to {high:g}' * (low < high)}" for key, (low, _, high) in new.items())
            why = "" if kind["right"] == kind["films"] else kind["why"]
            yield kind["kind"] if several else title, *_counts(kind), why, "; ".join(figures)
            shown[kind["kind"]] = own


def _counts(entry: Entry) -> list[str]:
    return [str(entry[name]) for name in ("films", *OUTCOMES)]


def _interval(entry: Entry) -> str:
    low, high = (100 * end for end in entry["interval"])
    return f"{low:.0f} to {high:.0f} %"


def written(page: Path) -> str:
    """A page of the project, with the tables of the scoreboard that is there."""
    cases = plan(Asked())
    return with_tables(page.read_text(encoding="utf-8"), document_of(cases, newest_rows(cases, SCOREBOARD / ROWS)))


if __name__ == "__main__":
    for each in PAGES:
        write_text(each, written(each))
    write_svg(roc_figure(_paper_rows(SCOREBOARD / ROWS)), ROC)
