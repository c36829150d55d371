"""bench: measure, print and save the project's figures of accuracy, safety and speed."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import (
    FolderPath,
    echo_lines,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    say,
    show_json,
)
from moireid_lab.bench.suites import BENCHES, SUITES, names_of
from moireid_lab.commands.sharing import data_option, scheduler_option, workers_option

#: Those of a suite first.
NAMES = tuple(dict.fromkeys([*SUITES, *BENCHES]))


@click.command("bench")
@click.argument("suite", type=click.Choice(NAMES), metavar="SUITE")
@click.option("--out", "folder", type=FolderPath(), help="Folder for rows, figures and plots; default: print alone.")
@click.option("--quick", is_flag=True, help="A few films only: minutes instead of hours.")
@click.option(
    "--clips", "--films", type=click.IntRange(1, 10000), metavar="NUMBER", help="Films, or repetitions, of each kind."
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    metavar="NUMBER",
    show_default=True,
    help="Seed of everything random.",
)
@click.option("--only", metavar="REGEX", help="Only the cases whose name holds this regular expression.")
@click.option("--keep", type=FolderPath(), help="Keep films there, and use those that are there.")
@data_option
@workers_option
@scheduler_option
@overwrite_option
@json_option
@friendly
def bench_command(
    suite: str,
    folder: Path | None,
    quick: bool,
    clips: int | None,
    seed: int,
    only: str | None,
    keep: Path | None,
    data: Path | None,
    workers: int | None,
    scheduler: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Measure a suite of figures, and print its tables.

    \b
    films      true and forged badges: outside, natural, reality, stability,
               builds, lenses, half-real, small-pages, kept, priors
    attacks    forgers, replayed, morphed, turned, laid-over, live,
               live-enrolment
    identity   identities read, originals against copies, false matches
    cost       processor time, memory and error: cost, registry, simulate
    pages      what is printed, read back: ink-growth, fabricate, mounts
    paper      the published paper's experiments (moireid lab paper)

    SUITE may also be one of the benches named there. With --out, each writes its rows as JSON, and a plot if it has
    one; rows are kept in NAME.jsonl as they are made, so a run that was interrupted goes on there. Films are shared
    out as in `moireid lab evaluate` (--workers, --scheduler).
    """
    from moireid.files import planned
    from moireid_lab.bench.bench_frame import Wish, bench_of, document_of, outputs, table_text, write
    from moireid_lab.bench.bench_rows import Where

    names = names_of(suite)
    benches = {name: bench_of(name) for name in names}
    if folder is not None:
        planned((path for name in names for path in outputs(folder, name, benches[name])), overwrite=overwrite)
        folder.mkdir(parents=True, exist_ok=True)
    documents = []
    for name, bench in benches.items():
        kept = folder / f"{name}.jsonl" if folder else None
        with progress_bar(name) as progress:
            wish = Wish(quick, seed, clips, only, kept, keep, Where(scheduler, workers), progress, data)
            rows = list(bench.rows(wish))
        documents.append(document_of(name, wish, rows))
        for path in write(folder, name, bench, documents[-1], overwrite=overwrite) if folder else ():
            say(f"written: {path}")
        if not as_json:
            echo_lines(table_text(bench, rows))
    if as_json:
        show_json(documents[0] if len(documents) == 1 else {"suite": suite, "benches": documents})
