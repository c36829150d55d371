"""The figures of a collection as text."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any

from moireid_lab.evaluation.summary import VERDICTS
from moireid_lab.evaluation.text_table import table_lines

Document = dict[str, Any]
WIDTH, KINDS = 26, ("genuine", "forged")
#: Most failed films that are listed.
LISTED = 10


def table(document: Document) -> str:
    """A summary, then all tables: distributions and verdicts by group, both pipelines side by side, failed films."""
    lines = [f"{document['films']} films: {document['genuine']} genuine, {document['forged']} forged"]
    lines += [_summary(name, figures) for name, figures in document["pipelines"].items()]
    for name, figures in document["pipelines"].items():
        lines += ["", f"{name}: {figures['score']}", *_groups(figures["groups"])]
    lines += ["", *_side_by_side(document), *_attacks(document["pipelines"])]
    lines += _failed(document["rows"])
    return "\n".join(lines)


def _summary(name: str, figures: Document) -> str:
    """What came out, in a sentence: right, inconclusive or failed, and wrong films of each label."""
    said = []
    for kind, right, wrong in (("genuine", "accept", "reject"), ("forged", "reject", "accept")):
        films = {verdict: row["films"] for verdict, row in figures["verdicts"][kind].items()}
        if of := sum(films.values()):
            left = of - films[right] - films[wrong]
            said.append(f"{kind}: {films[right]} of {of} {right}ed, {films[wrong]} {wrong}ed, {left} without an answer")
    auc = figures["scored_films"].get("auc")
    return f"  {name}: " + "; ".join(said) + (f"; AUC {auc:.3f}" if auc is not None else "")


def _groups(groups: list[Document]) -> Iterator[str]:
    """A line for each group and label."""
    counted = dict(zip(("accept", "reject", "incon.", "failed"), VERDICTS, strict=True))
    names = ("mean", "sd", "least", "median", "most")
    columns = {
        name: f"<{2 + max(len(name), *(len(row[name][:WIDTH]) for row in groups))}" for name in ("group", "label")
    }
    columns |= dict.fromkeys(("films", "scored", *counted), ">8") | dict.fromkeys(names, ">9.3f")
    rows = (
        row
        | {name: row[name][:WIDTH] for name in ("group", "label")}
        | {name: row["verdicts"][verdict]["films"] for name, verdict in counted.items()}
        for row in groups
    )
    return table_lines(rows, columns)


def _table(heading: str, rows: Iterable[tuple[str, Sequence[str]]], names: Collection[str]) -> list[str]:
    """A line for each figure: its name, and a cell for each of the names."""
    columns = {heading: f"<{max(40, len(heading))}"} | dict.fromkeys(names, ">26")
    shown = ({heading: name} | dict(zip(names, cells, strict=True)) for name, cells in rows)
    return list(table_lines(shown, columns))


#: Figures of a pipeline, each by its name: where it is; the paper's own, where it has it.
ROWS = {
    "films without a score": "without_score",
    "AUC of films with a score": "scored_films.auc",
    "AUC of all films (no score: the lowest)": "all_films.auc",
    "EER of films with a score": "scored_films.eer",
    "EER of all films": "all_films.eer",
    "threshold of greatest accuracy": "scored_films.best_threshold.threshold",
    "  accuracy there (on these very films)": "scored_films.best_threshold.accuracy",
    "  balanced accuracy": "scored_films.best_threshold.balanced_accuracy",
    "accuracy at its own limit, all films": "at_limit.accuracy",
    "  balanced accuracy there": "at_limit.balanced_accuracy",
    "Cllr, bits (0 best; 1 no information)": "likelihood_ratio.cllr",
    "  least, if calibrated here (PAV)": "likelihood_ratio.cllr_min",
    "  lost by calibration": "likelihood_ratio.calibration_loss",
    "  genuine films, ratio on the wrong side": "likelihood_ratio.misleading.genuine",
    "  forged films, ratio on the wrong side": "likelihood_ratio.misleading.forged",
}


def _side_by_side(document: Document) -> list[str]:
    """The figures of each pipeline in one column, and those of the paper next to them."""
    pipelines, paper = list(document["pipelines"].values()), document["paper"]
    rows: list[tuple[str, Sequence[str]]] = [
        (
            f"{kind} films: |rho| over 30 frames",
            [*(_spread(one["window_correlation"][kind]) for one in pipelines), _spread(paper[kind])],
        )
        for kind in KINDS
    ]
    for name, place in ROWS.items():
        shown = str(paper["auc"]) if place == "scored_films.auc" else ""
        rows.append((name, [*(_shown(one, place) for one in pipelines), shown]))
    missing = "; ".join(
        f"{name}: {figures['scored_films']['missing']}"
        for name, figures in document["pipelines"].items()
        if "missing" in figures["scored_films"]
    )
    names = (*document["pipelines"], "paper, other films")
    return _table("95 % intervals in brackets", rows, names) + ([missing] if missing else [])


def _shown(pipeline: Document, place: str) -> str:
    """A figure with its interval, where it has one; a dash where there is none."""
    *path, last = place.split(".")
    found: Document = pipeline
    for part in path:
        found = found.get(part) or {}
    value = found.get(last)
    if isinstance(value, dict):
        return _rate(value)
    if value is None or isinstance(value, int):
        return "-" if value is None else str(value)
    within = found.get(f"{last}_interval")
    return f"{value:.3f}" + (f" [{within[0]:.3f}, {within[1]:.3f}]" if within else "")


def _attacks(pipelines: dict[str, Document]) -> list[str]:
    """Error rates in the terms of ISO/IEC 30107-3: a line for each kind of attack, the worst, and genuine films."""
    rates = [figures["iso_30107_3"] for figures in pipelines.values()]
    found: list[tuple[str, list[Document | None]]] = []
    for k, attack in enumerate(rates[0]["attacks"]):
        found.append((f"  APCER {attack['kind'][:WIDTH]}", [one["attacks"][k]["apcer"] for one in rates]))
        found.append(("    no answer (APNRR)", [one["attacks"][k]["apnrr"] for one in rates]))
    found.append(("  APCER, greatest of any kind", [one["apcer_max"] for one in rates]))
    found.append(("  BPCER", [one["bpcer"] for one in rates]))
    found.append(("    no answer (BPNRR)", [one["bpnrr"] for one in rates]))
    rows = [(name, [_rate(cell) if cell else "-" for cell in cells]) for name, cells in found]
    return ["", *_table("ISO/IEC 30107-3, shares of all films", rows, pipelines)]


def _failed(rows: list[Document]) -> list[str]:
    """The films that could not be scored, and why."""
    failed = [row for row in rows if row["verdict"] == "failed"]
    lines = [f"  line {row['line']}, {row['video']}, {row['pipeline']}: {row['error']}" for row in failed[:LISTED]]
    more = [f"  and {len(failed) - LISTED} more, in evaluate.json"] if len(failed) > LISTED else []
    return ["", "failed:", *lines, *more] if failed else []


def _spread(cell: Document) -> str:
    return "-" if cell["mean"] is None else f"{cell['mean']:.3f} ± {cell['sd']:.3f}"


def _rate(cell: Document) -> str:
    return (
        f"{cell['films']} of {cell['of']} [{cell['interval'][0]:.3f}, {cell['interval'][1]:.3f}]" if cell["of"] else "-"
    )
