"""The figures of a collection as text."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from moireid_lab.evaluation.summary import VERDICTS

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


def _groups(groups: list[Document]) -> list[str]:
    """A line for each group and label."""
    width = max(len("group"), *(len(row["group"][:WIDTH]) for row in groups)) + 2
    wide = max(len("label"), *(len(row["label"][:WIDTH]) for row in groups)) + 2
    counted = ("films", "scored", "accept", "reject", "incon.", "failed")
    names = ("mean", "sd", "least", "median", "most")
    head = f"  {'group':<{width}}{'label':<{wide}}" + "".join(f"{name:>8}" for name in counted)
    lines = [head + "".join(f"{name:>9}" for name in names)]
    for row in groups:
        counts = [row["films"], row["scored"], *(row["verdicts"][verdict]["films"] for verdict in VERDICTS)]
        lines.append(
            f"  {row['group'][:WIDTH]:<{width}}{row['label'][:WIDTH]:<{wide}}"
            + "".join(f"{n:>8}" for n in counts)
            + "".join(f"{_number(row[name]):>9}" for name in names)
        )
    return lines


def _side_by_side(document: Document) -> list[str]:
    """The figures of each pipeline in one column, and those of the paper next to them."""
    pipelines, paper = list(document["pipelines"].values()), document["paper"]
    wide = 26
    names = (*document["pipelines"], "paper, other films")
    lines = [f"{'95 % intervals in brackets':<40}" + "".join(f"{name:>{wide}}" for name in names)]

    def line(name: str, cell: Callable[[Document], str], of_paper: str = "") -> None:
        cells = "".join(f"{cell(p):>{wide}}" for p in pipelines) + f"{of_paper:>{wide}}"
        lines.append(f"{name:<40}{cells}".rstrip())

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
    return lines + ([missing] if missing else [])


def _attacks(pipelines: dict[str, Document]) -> list[str]:
    """Error rates in the terms of ISO/IEC 30107-3: a line for each kind of attack, the worst, and genuine films."""
    rates = [figures["iso_30107_3"] for figures in pipelines.values()]
    head = f"{'ISO/IEC 30107-3, shares of all films':<40}" + "".join(f"{name:>26}" for name in pipelines)
    lines = ["", head]

    def line(name: str, cells: list[Document | None]) -> None:
        lines.append(f"  {name[: WIDTH + 10]:<38}" + "".join(f"{_rate(cell) if cell else '-':>26}" for cell in cells))

    for k, attack in enumerate(rates[0]["attacks"]):
        line(f"APCER {attack['kind']}", [one["attacks"][k]["apcer"] for one in rates])
        line("  no answer (APNRR)", [one["attacks"][k]["apnrr"] for one in rates])
    line("APCER, greatest of any kind", [one["apcer_max"] for one in rates])
    line("BPCER", [one["bpcer"] for one in rates])
    line("  no answer (BPNRR)", [one["bpnrr"] for one in rates])
    return lines


def _by_group(pipelines: dict[str, Document]) -> list[str]:
    """AUC of each group; films without a score rank lowest."""
    first = next(iter(pipelines.values()))["by_group"]
    if not first:
        return []
    lines = ["", f"{'AUC by group (all films)':<30}{'against':<14}" + "".join(f"{name:>26}" for name in pipelines)]
    for k, row in enumerate(first):
        cells = [figures["by_group"][k] for figures in pipelines.values()]
        lines.append(
            f"  {row['group'][:WIDTH]:<28}{row['against']:<14}"
            + "".join(f"{_ranged(cell['auc'], cell['auc_interval']):>26}" for cell in cells)
        )
    return lines


def _detectors(detectors: dict[str, Document]) -> list[str]:
    """AUC of other detectors, and of ours on the films that each of them scored."""
    if not detectors:
        return []
    pipelines = list(next(iter(detectors.values()))["ours_on_these"])
    names = ("its own", *pipelines)
    lines = ["", f"{'AUC of other detectors (no part of a verdict)':<48}" + "".join(f"{name:>26}" for name in names)]
    for name, found in detectors.items():
        cells = [found["scored_films"], *(found["ours_on_these"][pipeline] for pipeline in pipelines)]
        label = f"{name[:WIDTH]}, {found['films'] - found['without_score']} of {found['films']} films"
        lines.append(
            f"  {label:<46}" + "".join(f"{_ranged(one.get('auc'), one.get('auc_interval')):>26}" for one in cells)
        )
    return lines


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
