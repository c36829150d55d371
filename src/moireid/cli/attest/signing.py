"""The options of `verify --sign`, and what they write: planned before the film is read, written when it is judged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Signing:
    """What is to be signed and written; the key was loaded, and the files can be written."""

    key: SigningKey
    attest_file: Path | None
    form: Form | None

    def write(self, document: dict[str, Any], video: Path) -> dict[str, Any]:
        """Sign a report, and write what was asked for.

        Parameters: document: as `Report.to_json`, with the `registry` that was asked.
        Returns: the report as it was signed.
        Raises: MoireIdError if it cannot be signed; then no file is left.
        """
        from moireid.attest.statement import attested

        report = attested(document, self.key)
        if self.attest_file is None:
            self._write_credentials(report, video)
        else:
            self._write_envelope(self.attest_file, report, video)
            say(f"signed verdict: {self.attest_file}")
        return report

    def _write_envelope(self, path: Path, report: dict[str, Any], video: Path) -> None:
        from moireid.attest import check, signed_envelope
        from moireid.attest.envelope import read_envelope
        from moireid.attest.statement import statement
        from moireid.files import whole_file

        text = signed_envelope(statement(report, video.name), self.key)
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
            found = check(read_envelope(temporary), film=video, key=self.key.public)
            if not found.holds:
                raise SpecError(f"the signed verdict does not hold ({found.faults[0].text}); nothing is written")
            self._write_credentials(report, video)

    def _write_credentials(self, report: dict[str, Any], video: Path) -> None:
        if self.form is None:
            return
        from moireid.attest.credentials import credentials_path, write_credentials

        words = write_credentials(report, video, self.form, self.key)
        say(f"content credentials: {credentials_path(video, self.form)}")
        say(f"note: {words}.")


def planned_signing(
    video: Path,
    key_file: Path | None,
    attest_file: Path | None,
    form: Form | None,
    *,
    overwrite: bool,
    kept: Sequence[Path | None] = (),
) -> Signing | None:
    """What is to be signed; None if nothing is.

    Parameters: kept: files that are read, besides film and key; no output may replace them.
    Raises: SpecError, MissingExtraError if it cannot be signed, before any work is done.
    """
    if key_file is None:
        for value, name in ((attest_file, "--attest"), (form, "--c2pa")):
            if value is not None:
                raise SpecError(f"{name} needs a key to sign with; add --sign KEY.pem")
        return None
    if attest_file is None and form is None:
        raise SpecError("--sign needs a place for the signed verdict; add --attest FILE, or --c2pa sidecar|embed")
    from moireid.attest import load_signing_key
    from moireid.attest.credentials import check_credentials_key, credentials_path
    from moireid.files import planned

    key = load_signing_key(key_file)
    if form is not None:
        check_credentials_key(key)
    outputs = [attest_file] if attest_file is not None else []
    outputs += [credentials_path(video, form)] if form is not None else []
    planned(outputs, overwrite=overwrite, kept=[video, key_file, *kept])
    return Signing(key, attest_file, form)
