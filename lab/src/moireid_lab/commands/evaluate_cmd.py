"""evaluate: a labelled collection in, figures of both pipelines out."""

from __future__ import annotations

import json
from pathlib import Path

import click

from moireid.cli.common import (
    FiniteRange,
    FolderPath,
    echo_lines,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    registry_option,
    say,
    show_json,
)
from moireid_lab.commands.sharing import scheduler_option, workers_option


@click.command("evaluate")
@click.argument("manifest_csv", metavar="MANIFEST")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the figures and plots.")
@registry_option
@click.option(
    "--badge", "badge_json", type=click.Path(path_type=Path), help="The badge.json for films without a claim."
)
@click.option(
    "--pipeline",
    type=click.Choice(["moireid", "published", "both"]),
    default="both",
    show_default=True,
    help="Our method, the published one (Qing et al. 2026), or both.",
)
@workers_option
@scheduler_option
@click.option(
    "--timeout",
    "timeout_s",
    type=FiniteRange(1, 1e6),
    default=3600.0,
    show_default=True,
    metavar="S",
    help="Longest time for one film with one pipeline, in seconds.",
)
@click.option(
    "--memory",
    "memory_mb",
    type=click.IntRange(256, 1_000_000),
    default=2048,
    show_default=True,
    metavar="MB",
    help="Most memory for one film, in megabytes.",
)
@click.option("--retry", is_flag=True, help="Score again the films that crashed or went beyond a limit.")
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    metavar="NUMBER",
    show_default=True,
    help="Seed of the random resampling.",
)
@overwrite_option
@json_option
@friendly
def evaluate_command(
    manifest_csv: str,
    folder: Path,
    registry_url: str | None,
    badge_json: Path | None,
    pipeline: str,
    workers: int | None,
    scheduler: str | None,
    timeout_s: float,
    memory_mb: int,
    retry: bool,
    seed: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Score a collection of labelled films.

    It gives verdicts, error rates as ISO/IEC 30107-3 names them, score distributions, ROC curves, and what the
    score is worth as a likelihood ratio, for our method and for the published one.

    MANIFEST is a CSV file with a line for each film. Paths in it are relative to it. Its columns:

    \b
    video     the film
    label     genuine, forged or forged:KIND
    claim     a badge.json, or a name or id in the registry; empty: --badge
    group     any word, by which results are grouped
    corners   optional, for films that lost their markers: a CSV file with the
              columns frame,x1,y1,x2,y2,x3,y3,x4,y4

    Results are kept in results.jsonl as they are made. So a run that was interrupted goes on, and only what has changed
    is scored again. A film that cannot be scored, crashes or goes beyond a limit counts as failed, and the run goes on.
    With --scheduler, its workers read films by the same paths.
    """
    from moireid import __version__
    from moireid.badge import load_badge
    from moireid.files import planned, write_text
    from moireid_lab.archive.isolated import Limits
    from moireid_lab.evaluation.collect import collect
    from moireid_lab.evaluation.film_rows import PIPELINES
    from moireid_lab.evaluation.manifest import read_manifest
    from moireid_lab.evaluation.plots import PLOTS, write_plots
    from moireid_lab.evaluation.summary import summarise
    from moireid_lab.evaluation.table import table

    outputs = [folder / "evaluate.json", *(folder / f"{name}.svg" for name in PLOTS)]
    planned(outputs, overwrite=overwrite, make_folders=False)
    badge = load_badge(badge_json) if badge_json else None
    manifest = read_manifest(manifest_csv, registry_url=registry_url, badge=badge)
    if manifest.unused:
        say(f"this column is not used: {', '.join(name[:40] or 'without a name' for name in manifest.unused)}")
    planned(outputs, overwrite=overwrite)
    pipelines = [name for name in PIPELINES if pipeline in (name, "both")]
    with progress_bar("films") as progress:
        scored = collect(
            manifest.entries,
            pipelines,
            kept=folder / "results.jsonl",
            scheduler=scheduler,
            workers=workers,
            limits=Limits(timeout_s, memory_mb),
            retry=retry,
            progress=lambda done, of, *_: progress(done, of),
        )
    document = {"moireid": __version__, "manifest": Path(manifest_csv).name} | summarise(scored, seed=seed)
    write_text(outputs[0], json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    for path in [outputs[0], *write_plots(document, folder)]:
        say(f"written: {path}")
    if as_json:
        show_json(document)
    else:
        echo_lines(table(document))
