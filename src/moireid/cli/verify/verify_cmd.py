"""verify: is the badge in a film real, and is it the claimed one?"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from moireid.cli.attest.signing import detectors_from, planned_signing
from moireid.cli.common import VERDICT_EXIT, friendly, progress_bar, show_json
from moireid.cli.verify.asked import asked_of, files_read
from moireid.cli.verify.judging import judge_apart, judge_here, plan_pages, write_pages_of
from moireid.cli.verify.options import Wish, check_wish, verify_options
from moireid.cli.verify.showing import show_verdict


@click.command("verify")
@click.argument("video", type=click.Path(path_type=Path))
@verify_options
@friendly
def verify_command(**given: Any) -> None:
    """Check a film: is the badge real, and is it the claimed one?

    The fringes must move as the optics of a real badge demand, and the badge must spell the claimed identity. Say whose
    badge it should be with --claim, or give its file with --badge.

    Exit code 0: accepted; 1: rejected; 2: bad input; 3: inconclusive.
    """
    wish = Wish(**given)
    check_wish(wish)
    scores = detectors_from(wish.detectors)
    kept = files_read(wish)
    signing = planned_signing(
        wish.video, wish.key_file, wish.attest_file, wish.timestamp_url, wish.form, overwrite=wish.overwrite, kept=kept
    )
    with asked_of(wish) as asked:
        plan_pages(wish.report_folder, overwrite=wish.overwrite, kept=kept)
        with progress_bar("reading the film") as progress:
            judge = judge_here if signing is None else judge_apart
            outcome = judge(wish, asked.found, scores, progress)
        known = asked.known(outcome.document, wish.claim)
    document = write_pages_of(outcome, signing, known, wish)
    if wish.as_json:
        show_json(document)
    else:
        show_verdict(document["verdict"].upper(), document, known)
    sys.exit(VERDICT_EXIT[document["verdict"]])
