"""Commands and options that are gone: each ends with exit code 2 in one sentence that says what to use instead."""

from __future__ import annotations

import click

from moireid.cli.common import BAD_INPUT

#: By the words as one types them after `moireid`, a command, its option and its value: what to use instead.
REMOVED = {
    "witness": "run another program that is a C2SP witness (https://c2sp.org/tlog-witness); --witness-key has its "
    "signatures checked",
    "render": "preview.png next to badge.json shows the badge, and simulate --scene worn films it as it is worn",
    "worker": "run `dask worker` where moireid-studio[cluster] is installed, and serve --scheduler ADDRESS",
    "film-set": "it is `moireid lab film-set`",
    "generator-kit": "it is `moireid lab generator-kit`",
    "calibrate-camera": "use calibrate --camera --out chart.pdf for the chart, and calibrate FILM --camera for its "
    "film",
    "calibrate --band": "give a photograph of the chart with the sheet on it",
    "first-badge --record": "verify --report DIR keeps what a film of the badge shows",
    "pitch-test --measured-scale": "give what a ruler reads on the print to calibrate --measured-scale",
    "materials --spare": "the list has 5 % of everything to spare; --out writes a CSV file to change numbers in",
    "print --mount holder": "the tray of --mount lanyard, clip or stand holds card and sheet",
    "enroll --expires": "revoke the badge when its time is over",
    "registry suspend": "revoke the badge, and issue another one when it is found: a badge is valid or revoked",
    "registry reinstate": "issue another badge: one that is revoked stays so",
    "registry revoke --since": "leave it out: films of before the revocation do not count either",
    "print --front array": "--axes xy or --axes hex sense more directions under a lenticular sheet",
    "simulate --leave-out": "what a scene does not need, such as glare without a lamp, is left out by itself",
    "simulate --quick": "leave it out: every film is now encoded as fast",
    "serve --storage": "leave it out: films wait in the studio's folder, and workers of --scheduler fetch them there",
    "verify --timestamp": "have the file of --attest stamped by another program, such as `openssl ts`",
    "attest check --authority": "check a time stamp of the file by the program that made it, such as `openssl ts`",
    "verify --photographs": "no film shows how many photographs it was made of; use --level live, or leave it out",
}


class Removed(click.ClickException):
    """What somebody asked for is gone; words: as in `REMOVED`."""

    exit_code = BAD_INPUT

    def __init__(self, words: str) -> None:
        super().__init__(f"'moireid {words}' was removed: {REMOVED[words]}")


def check_present(error: click.UsageError) -> None:
    """Raise Removed if a command, an option or a value that there is not is one that is gone."""
    path = error.ctx.command_path.partition(" ")[2] if error.ctx else ""
    for words in REMOVED:
        last = words.rpartition(" ")[2]
        meant = error.option_name == last if isinstance(error, click.NoSuchOption) else f"'{last}'" in error.message
        if meant and words.startswith(f"{path} "):
            raise Removed(words) from error
