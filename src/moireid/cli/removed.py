"""Commands and options that are gone: each ends with exit code 2 in one sentence that says what to use instead."""

from __future__ import annotations

import click

from moireid.cli.common import BAD_INPUT

_COSIGN = "have a C2SP witness cosign the checkpoint file, and add its line to the file"
_READERS = "readers give it, to `registry audit`, `verify`, `identify` and `attest check`, which check the signatures"

#: By the words as one types them after `moireid`, a command or a command and its option: what to use instead.
REMOVED = {
    "witness": "run another program that is a C2SP witness (https://c2sp.org/tlog-witness); --witness-key has its "
    "signatures checked",
    "worker": "run `dask worker` where moireid-studio[cluster] is installed, and serve --scheduler ADDRESS",
    "verdicts": "see the page Verdicts of the studio, or ask it for /api/verdicts as an admin",
    "serve --storage": "leave it out: films wait in the studio's folder, and workers of --scheduler fetch them there",
    "verify --photographs": "no film shows how many photographs it was made of; use --level live, or leave it out",
    "watch --token-file": "addresses are not opened here; let FFmpeg write into a pipe, and watch -",
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
