"""identify: whose badge a film shows, of all in a registry or a bundle of it."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import click

from moireid.cli.common import (
    ACCEPT,
    INCONCLUSIVE,
    REJECT,
    bundle_option,
    camera_held,
    camera_option,
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
from moireid.cli.verify.verify_options import focal_option
from moireid.cli.witness_options import WitnessCheck, require, witness_check
from moireid.errors import SpecError


@click.command("identify")
@click.argument("video", type=click.Path(path_type=Path))
@registry_option
@bundle_option
@trust_option
@focal_option
@camera_option
@track_option
@unsealed_option
@json_option
@friendly
@witness_check
def identify_command(
    video: Path,
    registry_url: str | None,
    bundle_path: Path | None,
    trust: str | None,
    witness_check: WitnessCheck | None,
    focal_px: float | None,
    camera_file: Path | None,
    track: int | None,
    unsealed: bool,
    as_json: bool,
) -> None:
    """Find out whose badge a film shows.

    Everyone in the registry, or in the bundle, is considered, and no claim is needed.

    Exit code 0: found; 1: no one enrolled; 2: bad input; 3: inconclusive.
    """
    from moireid.api.asking import AskingTerms, people_of_bundle, people_of_registry
    from moireid.reading.film_orders import IdentifyingOrder

    if bundle_path is not None and registry_url is not None:
        raise SpecError("--bundle replaces --registry; leave one of them out")
    camera = camera_held(camera_file, focal_px)
    terms = AskingTerms(trust, report_standing, partial(require, witness_check))
    films = sealed_reader([video], unsealed=unsealed)
    people = people_of_registry(registry_url, terms) if bundle_path is None else people_of_bundle(bundle_path, terms)
    with people as scope, films as reader, progress_bar("reading the film") as progress:
        order = IdentifyingOrder(video, scope.layouts, focal_px, camera, track)
        document, known = scope.search(order, reader, progress)
    if as_json:
        show_json(document)
    else:
        show_verdict(document["finding"].upper(), document, known)
    sys.exit({"found": ACCEPT, "nobody": REJECT, "inconclusive": INCONCLUSIVE}[document["finding"]])
