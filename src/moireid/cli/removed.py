"""Commands and options that are gone: each ends with exit code 2 in one sentence that says what to use instead."""

from __future__ import annotations

from typing import Any

import click

from moireid.cli.common import BAD_INPUT

_COSIGN = "have a C2SP witness cosign the checkpoint file, and add its line to the file"
_READERS = "readers give it, to `registry audit`, `verify`, `identify` and `attest check`, which check the signatures"
_QUORUM = "give --witness-key for those witnesses alone whose signatures you ask for"
_ANEW = "enroll a badge that was built anew with --capture and --replace"
_DAYS = "signatures of witnesses count for 7 days"

#: By the words as one types them after `moireid`, a command, its option and its value: what to use instead.
REMOVED = {
    "witness": "run another program that is a C2SP witness (https://c2sp.org/tlog-witness); --witness-key has its "
    "signatures checked",
    "render": "preview.png next to badge.json shows the badge, and simulate --scene worn films it as it is worn",
    "print --acrylic": "give --mount-figure base_mm=MM",
    "print --key": "give --payload: 32 hex digits of the key's SHA-256 fingerprint",
    "print --kerf": "give --mount-figure kerf_mm=MM",
    "print --front array": "--axes xy or --axes hex sense more directions under a lenticular sheet",
    "print --actor": "set the variable MOIREID_ACTOR",
    "print --code": "in Python, moireid.design(…, code='pitch') draws the published prototype's code",
    "print --gap": "give the spacer's thickness as --lens-thickness",
    "print --ink-growth": "give a printer's profile as --printer, as moireid calibrate --printer-out writes it",
    "print --pattern": "lines bend where they may; in Python, moireid.design(…, pattern='cells') ends them",
    "print --skip-bad": "take the rows that are named out of the list",
    "print --typeface": "give a template of your own: its key typeface says sans, serif or slab",
    "simulate --sheet": "give --flaw: thickness=0.68, air=0.1, bow=1.5, lens-scale=1.0014, jitter=0.005 or feed=1.003",
    "simulate --lens-model": "give --camera wide or webcam, or film through a moireid.simulate.Camera of that lens",
    "simulate --format": "let FFmpeg scale the film: -vf scale=848:480 -r 24",
    "simulate --codec": "let FFmpeg code the film anew: -c:v libx265; --effect hlg is H.265 with 10 bits",
    "simulate --crf": "give --effect crf, or let FFmpeg code the film anew: -crf NUMBER",
    "simulate --mirror": "let FFmpeg mirror the film: -vf hflip",
    "simulate --blur": "let FFmpeg blur the film: -vf gblur=sigma=PX; --camera webcam is a little soft",
    "film-set": "it is `moireid lab film-set`",
    "generator-kit": "it is `moireid lab generator-kit`",
    "config": "set MOIREID_REGISTRY, MOIREID_LENS, MOIREID_PAPER, MOIREID_ACTOR or MOIREID_PUBLIC_URL in your shell",
    "worker": "run `dask worker` where moireid-studio[cluster] is installed, and serve --scheduler ADDRESS",
    "verdicts": "keep the reports that count: verify --report, or a report of the studio",
    "serve --keep-verdicts": "leave it out: keep the reports that count",
    "serve --storage": "leave it out: films wait in the studio's folder, and workers of --scheduler fetch them there",
    "lab evaluate --detector-scores": "join them with the rows of evaluate.json, which have each film's name and label",
    "verify --corners": "moireid lab evaluate reads the corners of films without markers from its list",
    "verify --detector": "leave it out: other programs' scores are no part of a verdict",
    "verify --schema": "the schema is in the package: moireid/schema/report.schema.json",
    "lab evaluate --film-limit": "films are read where they are; mount an archive that is elsewhere",
    "attest check --schema": "the schema is in the package: moireid/schema/attestation.schema.json",
    "verify --photographs": "no film shows how many photographs it was made of; use --level live, or leave it out",
    "calibrate-camera": "use calibrate --camera --out chart.pdf for the chart, and calibrate FILM --camera for its "
    "film",
    "calibrate --band": "give a photograph of the chart with the sheet on it",
    "first-badge --sheet-photo": "put the photo into the folder as sheet-photo.jpg",
    "first-badge --sheet-film": "put the film into the folder as sheet-film.mp4",
    "first-badge --camera-film": "put the film into the folder as camera-film.mp4",
    "first-badge --badge-film": "put the films into the folder as badge-film-1.mp4 and badge-film-2.mp4",
    "materials --event": "give --badge with one badge.json of the event's folder, and --people",
    "materials --made": "give --mount acrylic for one that is cut from acrylic",
    "materials --orientation": "give --badge with a badge.json of that orientation",
    "materials --price": "fill in the prices in shopping-list.csv",
    "materials --trim": "3 mm are cut off at each edge; give a smaller --sheet-size to cut off more",
    "materials --cut-width": "cut the sheets with a knife or a paper cutter, which takes nothing away",
    "verify --live-check": "keep the receipt next to the report: it names the film by its SHA-256",
    "verify --require-original": "give --level enrolled",
    "verify --no-require-original": _ANEW,
    "watch --require-original": "give --level enrolled",
    "watch --no-require-original": _ANEW,
    "verify --witnesses": _QUORUM,
    "verify --witness-days": _DAYS,
    "identify --witnesses": _QUORUM,
    "identify --witness-days": _DAYS,
    "attest check --witnesses": _QUORUM,
    "attest check --witness-days": _DAYS,
    "registry audit --witnesses": _QUORUM,
    "registry audit --witness-days": _DAYS,
    "serve --witnesses": _QUORUM,
    "serve --witness-days": _DAYS,
    "watch --enroll": "the studio's page Live measures a badge in a live check",
    "watch --receipt": "a one-time link of the studio gives a receipt",
    "watch --about": "a one-time link of the studio asks the person about a film",
    "watch --token-file": "addresses are not opened here; let FFmpeg write into a pipe, and watch -",
    "registry prove": "registry publish writes a bundle, which proves it to readers without the registry",
    "registry check-proof": "verify --bundle and attest check --bundle check what registry publish wrote",
    "registry audit --expected-head": "give --since with a checkpoint: registry checkpoint --out FILE writes it",
    "registry checkpoint --witness": _COSIGN,
    "registry checkpoint --witness-key": _READERS,
    "registry checkpoint --witnesses": _READERS,
    "registry checkpoint --witness-days": _READERS,
    "registry publish --witness": f"{_COSIGN}, then publish with --checkpoint FILE",
    "registry publish --witness-key": _READERS,
    "registry publish --witnesses": _READERS,
    "registry publish --witness-days": _READERS,
}


class Removed(click.ClickException):
    """What somebody asked for is gone; words: as in `REMOVED`."""

    exit_code = BAD_INPUT

    def __init__(self, words: str) -> None:
        super().__init__(f"'moireid {words}' was removed: {REMOVED[words]}")


def removed_option(error: click.NoSuchOption) -> Removed | None:
    """What to say of an option that a command does not have; None if it never had it."""
    path = error.ctx.command_path if error.ctx else ""
    words = f"{path.partition(' ')[2]} {error.option_name}"
    return Removed(words) if words in REMOVED else None


class RemainingCommands(click.Group):
    """A group of commands; one that is gone ends in its sentence."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command.  Raises: Removed if it is gone."""
        if (words := f"{self.name} {cmd_name}") in REMOVED:
            raise Removed(words)
        return super().get_command(ctx, cmd_name)


class RemainingChoice(click.Choice[str]):
    """A choice of values; one that is gone ends in its sentence."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The value.  Raises: Removed, or click.BadParameter for one that never was."""
        if param and ctx and (words := f"{ctx.command.name} {param.opts[0]} {value}") in REMOVED:
            raise Removed(words)
        return super().convert(value, param, ctx)
