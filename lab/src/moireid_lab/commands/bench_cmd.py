"""bench: measure, print and save the project's figures of accuracy and speed."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import (
    FolderPath,
    echo_lines,
    fail,
    friendly,
    json_option,
    overwrite_option,
    progress_bar,
    say,
    show_json,
)
from moireid_lab.commands.rate import scheduler_option, workers_option

#: The names of `bench.suites.SUITES`, written again because importing them takes seconds.
NAMES = ("identity", "stability", "fabricate", "simulate", "verify", "forgers", "reality", "natural", "published")
#: Suites whose cases can be chosen; the file of rows of one whose name it has not.
WITH_CASES, KEPT = ("forgers", "reality", "natural", "stability"), {"identity": "clips.jsonl"}


@click.command("bench")
@click.argument("suite", type=click.Choice(NAMES))
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the figures and plots.")
@click.option("--quick", is_flag=True, help="A few films only: minutes instead of hours.")
@click.option(
    "--clips",
    type=click.IntRange(1, 10000),
    metavar="NUMBER",
    help="Films for each condition; default: 100, or 4 with --quick (published: 10, or 2; reality: 10, or 1; "
    "natural: 5, or 1).",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    metavar="NUMBER",
    show_default=True,
    help="Seed of everything random.",
)
@click.option(
    "--only",
    metavar="REGEX",
    help="Only the cases whose name holds this regular expression (forgers, reality, natural, stability).",
)
@workers_option
@scheduler_option
@overwrite_option
@json_option
@friendly
def bench_command(
    suite: str,
    folder: Path,
    quick: bool,
    clips: int | None,
    seed: int,
    only: str | None,
    workers: int | None,
    scheduler: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Measure a suite of figures, and print its table.

    \b
    identity    identities read, originals against copies, false matches
    stability   stiff and extreme cases
    fabricate   errors of the printed page and the mount, also at extremes
    simulate    the renderers against an outside tracer; error against run time
    verify      the verifier's error against its run time; extreme motions
    forgers     attacks by those who read this code: photographs, stills, delays;
                and honest films with hands, captions and cuts
    reality     true and forged badges filmed by phones, editors, calls and
                services; at strengths but the ordinary, forged ones by --only
    natural     true badges filmed with measured motions; verdicts on parts of
                4 to 40 s of each film
    published   the published paper's tables on simulated films, next to ours

    The figures and a plot go into the folder of --out. Films of suites without run times, and the extreme
    motions of verify, are shared out as in `moireid lab evaluate` (--workers, --scheduler); timed work runs alone.

    Figures of finished films are kept in clips.jsonl, verify.jsonl, forgers.jsonl, reality.jsonl and natural.jsonl, so
    a run that was interrupted goes on there.
    """
    from moireid.files import planned
    from moireid_lab.bench.bench_frame import Wish
    from moireid_lab.bench.bench_rows import Where
    from moireid_lab.bench.suites import SUITES, outputs, write

    if suite in ("fabricate", "simulate") and (workers or scheduler):
        fail(f"{suite} has no films to share out; leave out --workers and --scheduler")
    if only is not None and suite not in WITH_CASES:
        fail(f"--only chooses cases of {', '.join(WITH_CASES)}, and {suite} has none; leave it out")
    planned(outputs(folder, suite), overwrite=overwrite)
    kept = None if suite in ("stability", "published") else folder / KEPT.get(suite, f"{suite}.jsonl")
    with progress_bar("clips") as progress:
        folder.mkdir(parents=True, exist_ok=True)
        where = Where(scheduler, workers)
        wish = Wish(quick, seed, clips, only, kept, folder, overwrite, where, progress)
        result = SUITES[suite].run(wish)
    for path in write(folder, result, overwrite=overwrite):
        say(f"written: {path}")
    if as_json:
        show_json(result)
    else:
        echo_lines(SUITES[suite].table(result))
