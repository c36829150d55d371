"""The figures of a collection as text."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import Any

from moireid_lab.evaluation.summary import VERDICTS
from moireid_lab.evaluation.text_table import table_lines

Document = dict[str, Any]
WIDTH = 26
#: Most failed films that are listed.
LISTED = 10


def table(document: Document) -> str:
    """The whole table: distributions and verdicts by group, both pipelines side by side, failed films."""
    lines = [f"{document['films']} films: {document['genuine']} genuine, {document['forged']} forged"]
    for name, figures in document["pipelines"].items():
        lines += ["", f"{name}: {figures['score']}", *_groups(figures["groups"])]
    lines += ["", *_side_by_side(document), *_attacks(document["pipelines"])]
    lines += [*_by_group(document["pipelines"]), *_detectors(document.get("detectors", {}))]
    lines += _failed(document["rows"])
    return "\n".join(lines)


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


def _side_by_side(document: Document) -> list[str]:
    """The figures of each pipeline in one column, and those of the paper next to them."""
    pipelines, paper = list(document["pipelines"].values()), document["paper"]
    rows: list[tuple[str, Sequence[str]]] = []

    def line(name: str, cell: Callable[[Document], str], of_paper: str = "") -> None:
        rows.append((name, [*map(cell, pipelines), of_paper]))

    def ranged(part: str, name: str) -> Callable[[Document], str]:
        return lambda p: _ranged(p[part].get(name), p[part].get(f"{name}_interval"))

    def rate(kind: str, verdict: str) -> Callable[[Document], str]:
        return lambda p: _rate(p["verdicts"][kind][verdict])

    def misled(kind: str) -> Callable[[Document], str]:
        return lambda p: _misled(p, kind)

    def window(kind: str) -> Callable[[Document], str]:
        return lambda p: _spread(p["window_correlation"][kind])

    for kind in ("genuine", "forged"):
        line(f"{kind} films: |rho| over 30 frames", window(kind), _spread(paper[kind]))
    line("films without a score", lambda p: str(p["without_score"]))
    line("AUC of films with a score", ranged("scored_films", "auc"), str(paper["auc"]))
    line("AUC of all films (no score: the lowest)", ranged("all_films", "auc"))
    line("EER of films with a score", ranged("scored_films", "eer"))
    line("EER of all films", ranged("all_films", "eer"))
    line("threshold of greatest accuracy", lambda p: _number(_best(p).get("threshold")))
    line(
        "  accuracy there (on these very films)",
        lambda p: _ranged(_best(p).get("accuracy"), _best(p).get("accuracy_interval")),
    )
    line("  balanced accuracy", lambda p: _number(_best(p).get("balanced_accuracy")))
    line(
        "accuracy at its own limit, all films",
        lambda p: _ranged(p["at_limit"]["accuracy"], p["at_limit"]["accuracy_interval"]),
    )
    line("  balanced accuracy", lambda p: _number(p["at_limit"]["balanced_accuracy"]))
    line("Cllr, bits (0 best; 1 no information)", lambda p: _ranged(_ratio(p, "cllr"), _ratio(p, "cllr_interval")))
    line("  least, if calibrated here (PAV)", lambda p: _number(_ratio(p, "cllr_min")))
    line("  lost by calibration", lambda p: _number(_ratio(p, "calibration_loss")))
    for kind in ("genuine", "forged"):
        line(f"  {kind} films, ratio on the wrong side", misled(kind))
    line(
        "genuine less forged, means (Welch)", lambda p: _ranged(_welch(p).get("difference"), _welch(p).get("interval"))
    )
    line("  Welch's t (df)", lambda p: f"{_number(_welch(p).get('t'))} ({_number(_welch(p).get('df'))})")
    line("  p", lambda p: "-" if _welch(p).get("p") is None else f"{_welch(p)['p']:.2g}")
    line("Cohen's d", ranged("scored_films", "cohens_d"))
    for kind in ("genuine", "forged"):
        for verdict in VERDICTS:
            line(f"{kind} films: {verdict}", rate(kind, verdict))
    missing = "; ".join(
        f"{name}: {figures['scored_films']['missing']}"
        for name, figures in document["pipelines"].items()
        if "missing" in figures["scored_films"]
    )
    names = (*document["pipelines"], "paper, other films")
    return _table("95 % intervals in brackets", rows, names) + ([missing] if missing else [])


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


def _by_group(pipelines: dict[str, Document]) -> list[str]:
    """AUC of each group; films without a score rank lowest."""
    groups = [figures["by_group"] for figures in pipelines.values()]
    rows = [
        (f"  {row['group'][:WIDTH]}, against {row['against']}", [_area(of[k]) for of in groups])
        for k, row in enumerate(groups[0])
    ]
    return ["", *_table("AUC by group (all films)", rows, pipelines)] if rows else []


def _detectors(detectors: dict[str, Document]) -> list[str]:
    """AUC of other detectors, and of ours on the films that each of them scored."""
    if not detectors:
        return []
    pipelines = list(next(iter(detectors.values()))["ours_on_these"])
    rows = [
        (
            f"  {name[:WIDTH]}, {found['films'] - found['without_score']} of {found['films']} films",
            [_area(one) for one in (found["scored_films"], *(found["ours_on_these"][each] for each in pipelines))],
        )
        for name, found in detectors.items()
    ]
    return ["", *_table("AUC of other detectors (no part of a verdict)", rows, ("its own", *pipelines))]


def _area(found: Document) -> str:
    return _ranged(found.get("auc"), found.get("auc_interval"))


def _failed(rows: list[Document]) -> list[str]:
    """The films that could not be scored, and why."""
    failed = [row for row in rows if row["verdict"] == "failed"]
    lines = [f"  line {row['line']}, {row['video']}, {row['pipeline']}: {row['error']}" for row in failed[:LISTED]]
    more = [f"  and {len(failed) - LISTED} more, in evaluate.json"] if len(failed) > LISTED else []
    return ["", "failed:", *lines, *more] if failed else []


def _ratio(pipeline: Document, name: str) -> Any:
    return (pipeline["likelihood_ratio"] or {}).get(name)


def _misled(pipeline: Document, kind: str) -> str:
    found = _ratio(pipeline, "misleading")
    return _rate(found[kind]) if found else "-"


def _best(pipeline: Document) -> Document:
    return pipeline["scored_films"].get("best_threshold") or {}


def _welch(pipeline: Document) -> Document:
    return pipeline["scored_films"].get("welch") or {}


def _spread(cell: Document) -> str:
    return "-" if cell["mean"] is None else f"{cell['mean']:.3f} ± {cell['sd']:.3f}"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def _ranged(value: float | None, found: list[float] | None) -> str:
    return _number(value) + (f" [{found[0]:.3f}, {found[1]:.3f}]" if found else "")


def _rate(cell: Document) -> str:
    return (
        f"{cell['films']} of {cell['of']} [{cell['interval'][0]:.3f}, {cell['interval'][1]:.3f}]" if cell["of"] else "-"
    )
