"""The paper's tables from the rows of `paper`: a cell has ours / the published pipeline's / the paper's figure.

Convention: the first row of a table is its heading; "–" where there is no figure, in the paper or here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ttest_ind

from moireid.verifier.decision.figures import calibrated_log10
from moireid_lab.baseline.pipeline import THRESHOLD
from moireid_lab.bench.bench_frame import grouped
from moireid_lab.bench.part import Row
from moireid_lab.bench.scoreboard import described
from moireid_lab.evaluation.plots import curves
from moireid_lab.evaluation.statistics import area, roc
from moireid_lab.evaluation.summary import PAPER, separation

Array = NDArray[np.float64]
REAL, GENERATED = "real (stand-ins)", "generated (stand-ins)"
FIGURES = ("mean", "sd", "least", "greatest", "global")
#: The paper's figures, by the start of a set's name and by field: window mean, least, greatest, and whole film.
PANELS = {
    ("rendering", "x"): ("0.99", "–", "–", "–"),
    ("A", "x"): ("0.951", "0.722", "0.998", "0.807"),
    ("A", "y"): ("0.854", "0.561", "0.999", "0.325"),
    ("B, trajectory 1", "x"): ("0.758", "0.033", "0.990", "0.141"),
    ("B, trajectory 2", "x"): ("0.809", "0.445", "0.987", "0.024"),
    ("C", "x"): ("0.720", "0.139", "0.997", "0.447"),
    ("D", "x"): ("0.667", "0.045", "0.998", "0.713"),
    ("D", "y"): ("0.570", "0.004", "0.988", "0.709"),
}
#: Thresholds of the published score at which rates are shown.
THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9, THRESHOLD, 0.95, 0.98, 0.99, 0.995)
#: Scores by which true films are told from false ones: where a row has them, and their colour.
SCORES = {
    "ours, log10 odds": ("score", "#1f6fb2"),
    "published, greatest window": ("greatest", "#8a97a6"),
    "published, window mean": ("mean", "#c2571a"),
}
#: Of the paper's films: true, false, Welch's t and p, Cohen's d, area under the curve, best threshold.
STATED = (
    f"{PAPER['genuine']['mean']:.2f} ± {PAPER['genuine']['sd']:.2f}",
    f"{PAPER['forged']['mean']:.2f} ± {PAPER['forged']['sd']:.2f}",
    "t(160) = 11.6, p < 1e-20",
    "1.71",
    "0.845",
    f"{THRESHOLD}",
)


def sets(rows: Sequence[Row]) -> Iterator[Sequence[str]]:
    """Each set and field, rendering 1 by distance, next to the paper."""
    yield "set", "films", *(f"window {name}" for name in FIGURES[:-1]), "global", "likely real"
    for (name, metres), own in grouped(_experiments(rows), "kind", "metres").items():
        for axis in own[0]["fields"]:
            paper = [values for (start, of), values in PANELS.items() if name.startswith(start) and of == axis]
            mean, least, greatest, whole = paper[0] if paper else ("–",) * 4
            stated = (mean, "–", least, greatest, whole)
            cells = [
                f"{_mean(own, axis, key, True)} / {_mean(own, axis, key)} / {one}"
                for key, one in zip(FIGURES, stated, strict=True)
            ]
            likely = sum((row["fields"][axis]["greatest"] or 0) >= THRESHOLD for row in own)
            yield f"{name}, {axis}, {metres:g} m", str(len(own)), *cells, f"{likely} / {'all' if paper else '–'}"


def verdicts(rows: Sequence[Row]) -> Iterator[Sequence[str]]:
    """What our method says of each set, and what strength it gives it."""
    yield "set", "films", "accepted", "inconclusive", "rejected", "odds, median", "most frequent findings"
    for name, own in grouped([*_experiments(rows), *_stand_ins(rows)], "kind").items():
        counts = Counter(row["verdict"] for row in own)
        odds = [calibrated_log10(row["score"]) for row in own if row["score"] is not None]
        median = f"10^{np.median(odds):.1f}" if odds else "–"
        words = (str(counts[word]) for word in ("accept", "inconclusive", "reject"))
        yield name, str(len(own)), *words, median, described(own)["why"]


def rates(rows: Sequence[Row]) -> Iterator[Sequence[str]]:
    """The curve of the published score, and its accuracy, by threshold."""
    yield "threshold", "true accepted", "false accepted", "accuracy"
    true, false = (np.array(_scores(rows, name, "greatest")) for name in (REAL, GENERATED))
    for limit in THRESHOLDS if len(true) and len(false) else ():
        kept, taken = int((true >= limit).sum()), int((false >= limit).sum())
        accuracy = (kept + len(false) - taken) / (len(true) + len(false))
        yield f"{limit:g}", f"{kept / len(true):.3f}", f"{taken / len(false):.3f}", f"{accuracy:.3f}"


def statistics(rows: Sequence[Row]) -> Iterator[Sequence[str]]:
    """How the scores separate true films from false ones."""
    yield "score", "true", "false", "Welch", "Cohen's d", "area under the curve", "best threshold, accuracy"
    for words, (key, _) in SCORES.items():
        true, false = (np.array(_scores(rows, name, key), float) for name in (REAL, GENERATED))
        if min(len(true), len(false)) > 1:
            test, both = ttest_ind(true, false, equal_var=False), separation(true, false, 0, means=True)
            spread = np.sqrt((true.var(ddof=1) + false.var(ddof=1)) / 2)
            best = both["best_threshold"]
            yield (
                words,
                *(f"{one.mean():.3f} ± {one.std(ddof=1):.3f} ({len(one)})" for one in (true, false)),
                f"t({test.df:.0f}) = {test.statistic:.1f}, p = {test.pvalue:.1g}",
                f"{(true.mean() - false.mean()) / spread:.2f}",
                f"{both['auc']:.3f}",
                f"{best['threshold']:.3f}, {best['accuracy']:.3f}",
            )
    yield "the paper, on its own films (87, 92)", *STATED


def roc_figure(rows: Sequence[Row]) -> Any:
    """True films accepted against false ones, by score; films without a score are left out."""
    lines = []
    for words, (key, colour) in SCORES.items():
        true, false = (np.array(_scores(rows, name, key), float) for name in (REAL, GENERATED))
        if len(true) and len(false):
            curve = roc(true, false)
            lines.append((curve.false_accept, curve.true_accept, f"{words}: {area(curve):.3f}", colour))
    across = f"false films accepted, of {len(false)} (all simulated)"
    return curves(lines, across, f"true films accepted, of {len(true)}", "no films yet", 1, aspect="equal")


def causes(rows: Sequence[Row]) -> Iterator[Sequence[str]]:
    """What lowers the published score of rendering 1: one condition changed in each."""
    yield "rendering 1, but", "films", "greatest window", "window mean", "place", "phase"
    own = [row for row in rows if row["kind"].startswith("cause")]
    for (name, metres), some in grouped(own, "kind", "metres").items():
        cells = (_mean(some, "x", key) for key in ("greatest", "mean", "place", "phase"))
        yield f"{name.removeprefix('cause: ')}, {metres:g} m", str(len(some)), *cells


TABLES: dict[str, Callable[[Sequence[Row]], Iterator[Sequence[str]]]] = {
    "sets": sets,
    "verdicts": verdicts,
    "rates": rates,
    "statistics": statistics,
    "causes": causes,
}


def _stand_ins(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row["kind"] in (REAL, GENERATED)]


def _experiments(rows: Sequence[Row]) -> list[Row]:
    """Films of the paper's experiments, in their order."""
    own = [row for row in rows if row not in _stand_ins(rows) and not row["kind"].startswith("cause")]
    return sorted(own, key=lambda row: (row["kind"].replace("rendering", " rendering"), row["metres"]))


def _mean(rows: Sequence[Row], axis: str, key: str, ours: bool = False) -> str:
    """A figure's mean over films that have it; the least of the least."""
    fields = [row["fields"][axis]["ours"] if ours else row["fields"][axis] for row in rows]
    found = [one[key] for one in fields if one[key] is not None]
    return f"{(min(found) if key == 'least' else np.mean(found)):.3f}" if found else "–"


def _scores(rows: Sequence[Row], name: str, key: str) -> list[float]:
    """The scores of a set; films without one, which are in no figure of the paper, are left out."""
    own = [row for row in rows if row["kind"] == name]
    found = [row["score"] if key == "score" else row["fields"]["x"][key] for row in own]
    return [one for one in found if one is not None]
