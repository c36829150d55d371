"""identify: whose badge a film shows, of all in a registry or a bundle of it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    ACCEPT,
    INCONCLUSIVE,
    REJECT,
    bundle_option,
    camera_options,
    friendly,
    json_option,
    progress_bar,
    registry_option,
    report_standing,
    show_json,
    track_option,
    trust_option,
)
from moireid.cli.sealed_reader import sealed_reader, unsealed_option
from moireid.cli.verify.verify_cmd import show_verdict
from moireid.cli.witness_options import WitnessCheck, witness_check

if TYPE_CHECKING:
    from moireid.question import KnownCamera


@click.command("identify")
@click.argument("video", type=click.Path(path_type=Path))
@friendly
@registry_option
@bundle_option
@trust_option
@camera_options
@track_option
@unsealed_option
@json_option
@witness_check
def identify_command(
    video: Path,
    registry_url: str | None,
    bundle_path: Path | None,
    trust: str | None,
    witness_check: WitnessCheck | None,
    camera: KnownCamera | None,
    track: int | None,
    unsealed: bool,
    as_json: bool,
) -> None:
    """Find out whose badge a film shows.

    Everyone in the registry, or in the bundle, is considered, and no claim is needed.

    Exit code 0: found; 1: no one enrolled; 2: bad input; 3: inconclusive.
    """
    from moireid.api.asking import asked, search

    require = witness_check.require if witness_check else None
    people = asked(registry_url, bundle_path, trust, report_standing, require)
    films = sealed_reader([video], unsealed=unsealed)
    with people as (held, standing), films as reader, progress_bar("reading the film") as progress:
        document, known = search(held, standing, video, camera, track, reader, progress)
    if as_json:
        show_json(document)
    else:
        show_verdict(document["finding"].upper(), document, known)
    sys.exit({"found": ACCEPT, "nobody": REJECT, "inconclusive": INCONCLUSIVE}[document["finding"]])
