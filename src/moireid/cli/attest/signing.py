"""The options of `verify --sign`, and what they write: planned before the film is read, written when it is judged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import say
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.attest.credentials import Form
    from moireid.attest.signing_keys import SigningKey

#: In the order of the help.
OPTIONS = (
    click.option(
        "--sign",
        "key_file",
        metavar="KEY.pem",
        type=click.Path(path_type=Path),
        help="Sign the verdict with this private key (Ed25519 or P-256), and with its certificates if the file holds "
        "any. Needs --attest or --c2pa.",
    ),
    click.option(
        "--attest",
        "attest_file",
        metavar="FILE",
        type=click.Path(path_type=Path, dir_okay=False),
        help="Write the signed verdict here: an in-toto statement in a DSSE envelope, for `moireid attest check`.",
    ),
    click.option(
        "--c2pa",
        "form",
        type=click.Choice(["sidecar", "embed"]),
        help="Write the signed verdict as content credentials: FILM.c2pa next to the film, or a new film "
        "FILM.c2pa.mp4 that holds them. Needs moireid[c2pa], and a certificate in KEY.pem.",
    ),
)


def signing_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options by which verdicts are signed."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


def planned_signing(
    video: Path,
    key_file: Path | None,
    attest_file: Path | None,
    form: Form | None,
    *,
    overwrite: bool,
    kept: Sequence[Path | None] = (),
) -> Callable[[dict[str, Any]], dict[str, Any]] | None:
    """What signs a report of the film, and writes what was asked for; None if nothing is to be signed.

    Parameters: kept: files that are read, besides film and key; no output may replace them.
    Returns: it takes the report as `Report.to_json`, with the `registry` that was asked, and gives it as it was signed;
        it raises MoireIdError if that cannot be signed, and then no file is left.
    Raises: SpecError, MissingExtraError if it cannot be signed, before any work is done.
    """
    if key_file is None:
        for value, name in ((attest_file, "--attest"), (form, "--c2pa")):
            if value is not None:
                raise SpecError(f"{name} needs a key to sign with; add --sign KEY.pem")
        return None
    if attest_file is None and form is None:
        raise SpecError("--sign needs a place for the signed verdict; add --attest FILE, or --c2pa sidecar|embed")
    from moireid.attest.credentials import check_credentials_key, credentials_path
    from moireid.attest.signing_keys import load_signing_key
    from moireid.files import planned

    key = load_signing_key(key_file)
    if form is not None:
        check_credentials_key(key)
    outputs = [attest_file] if attest_file is not None else []
    outputs += [credentials_path(video, form)] if form is not None else []
    planned(outputs, overwrite=overwrite, kept=[video, key_file, *kept])
    return partial(_sign, video, key, attest_file, form)


def _sign(
    video: Path, key: SigningKey, attest_file: Path | None, form: Form | None, document: dict[str, Any]
) -> dict[str, Any]:
    """Sign a report, and write it; what `planned_signing` returns, of a key that was loaded."""
    from moireid.attest.checking import check
    from moireid.attest.credentials import credentials_path, write_credentials
    from moireid.attest.envelope import read_envelope, signed_envelope
    from moireid.attest.statement import attested, statement
    from moireid.files import whole_file

    report = attested(document, key)
    with ExitStack() as files:
        if attest_file is not None:
            temporary = files.enter_context(whole_file(attest_file))
            temporary.write_text(signed_envelope(statement(report, video.name), key), encoding="utf-8")
            found = check(read_envelope(temporary), film=video, key=key.public)
            if not found.holds:
                raise SpecError(f"the signed verdict does not hold ({found.faults[0].text}); nothing is written")
        if form is not None:
            words = write_credentials(report, video, form, key)
            say(f"content credentials: {credentials_path(video, form)}")
            say(f"note: {words}.")
    if attest_file is not None:
        say(f"signed verdict: {attest_file}")
    return report
