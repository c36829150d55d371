"""bench: measure, print and save the project's figures of accuracy and speed."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import FolderPath, fail, friendly, json_option, overwrite_option, progress_bar, say, show_json
from moireid_lab.commands.rate import scheduler_option, workers_option


@click.command("bench")
@click.argument(
    "suite",
    type=click.Choice(
        ["identity", "stability", "fabricate", "simulate", "verify", "forgers", "reality", "natural", "published"]
    ),
)
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
    help="Only the cases whose name holds this regular expression (forgers, reality, natural).",
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
    motions of verify, are shared out as in `moireid evaluate` (--workers, --scheduler); timed work runs alone.

    Figures of finished films are kept in clips.jsonl, verify.jsonl, forgers.jsonl, reality.jsonl and natural.jsonl, so
    a run that was interrupted goes on there.
    """
    from moireid.files import planned
    from moireid_lab.bench import stability as stability
    from moireid_lab.bench.bench_rows import Where
    from moireid_lab.bench.identity import identity_suite as identity
    from moireid_lab.bench.output import TABLES, outputs, write

    if suite in ("fabricate", "simulate") and (workers or scheduler):
        fail(f"{suite} has no films to share out; leave out --workers and --scheduler")
    if only is not None and suite not in ("forgers", "reality", "natural"):
        fail(f"--only chooses cases of forgers, reality or natural, and {suite} has none; leave it out")
    where = Where(scheduler, workers)
    planned(outputs(folder, suite), overwrite=overwrite)
    with progress_bar("clips") as progress:
        folder.mkdir(parents=True, exist_ok=True)
        if suite == "stability":
            result = stability.run(quick=quick, seed=seed, where=where, progress=progress)
        elif suite == "fabricate":
            from moireid_lab.bench.fabricate import fabricate_suite as fabricate

            result = fabricate.run(quick=quick, seed=seed, progress=progress)
        elif suite == "simulate":
            from moireid_lab.bench.simulate import simulate_suite as simulate

            result = simulate.run(quick=quick, seed=seed, progress=progress)
        elif suite == "verify":
            from moireid_lab.bench.verify import verify_suite as verify

            result = verify.run(quick=quick, seed=seed, kept=folder / "verify.jsonl", where=where, progress=progress)
        elif suite in ("forgers", "reality", "natural"):
            from moireid_lab.bench import natural as natural
            from moireid_lab.bench import reality as reality
            from moireid_lab.bench.forgers import forgers_suite as forgers

            kept = folder / f"{suite}.jsonl"
            films = {"forgers": forgers.run, "reality": reality.run, "natural": natural.run}[suite]
            result = films(quick=quick, seed=seed, clips=clips, only=only, kept=kept, where=where, progress=progress)
        elif suite == "published":
            from moireid_lab.bench import published as published

            result = published.run(
                quick=quick,
                seed=seed,
                folder=folder,
                overwrite=overwrite,
                where=where,
                clips=clips,
                progress=progress,
            )
        else:
            result = identity.run(
                quick=quick, seed=seed, clips=clips, kept=folder / "clips.jsonl", where=where, progress=progress
            )
    for path in write(folder, result, overwrite=overwrite):
        say(f"written: {path}")
    if as_json:
        show_json(result)
    else:
        click.echo(TABLES[suite](result))
