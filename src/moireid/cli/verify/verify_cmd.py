"""verify: is the badge in a film real, and is it the claimed one?

1. Find the claimed badge: in a registry, in a bundle, or in a file alone.
2. Judge the film, in a sealed process that was made before.
3. Look up what the registry or bundle says about the badge that was read.  This process does it, after the film is
   judged; a process that only decodes the film learns nothing but the claimed badge.
4. Sign the report and write its pages, if asked for.
5. Print the verdict: the result, what to do, and the findings, failures first.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.attest.signing import Signing, detectors_from, planned_signing, signing_options
from moireid.cli.common import VERDICT_EXIT, camera_held, echo, friendly, progress_bar, report_standing, say, show_json
from moireid.cli.sealed_reader import sealed_reader
from moireid.cli.verify.verify_options import ClaimWish, VerifyOptions, check_wish, verify_options
from moireid.cli.witness_options import require, witness_check

if TYPE_CHECKING:
    from moireid.provenance import ClaimedBadge, Standing
    from moireid.reading.film_orders import JudgingOrder
    from moireid.reading.film_reader import Reader
    from moireid.registry import Registry
    from moireid.verifier import Claim
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.report.headline import Headline
    from moireid.verifier.report.report_page import Pictures


#: From a report's JSON to the circumstances of the check.
LookUp = Callable[[Mapping[str, Any]], "Circumstances"]


@dataclass(frozen=True)
class ClaimContext:
    """A claimed badge, with the standing of the registry or bundle that was asked, and a look-up of reports there."""

    found: ClaimedBadge
    look_up: LookUp

    @property
    def standing(self) -> Standing | None:
        """None if neither was asked."""
        return self.found.provenance.standing

    def known(self, document: Mapping[str, Any], claim: str | None) -> Circumstances:
        """How the check of a report was made; claim: as it was typed."""
        return replace(self.look_up(document), claim=claim, barred=self.found.barred)


def files_read(wish: ClaimWish) -> list[Path | None]:
    """The files that are read of a claim, which no output may replace."""
    found = [wish.bundle_path, wish.badge_json]
    if wish.registry_url is None and (wish.claim is None or wish.bundle_path is not None):
        return found
    from moireid.registry.engine import own_file

    return [*found, own_file(wish.registry_url)]


def asked_of(wish: ClaimWish) -> AbstractContextManager[ClaimContext]:
    """The claimed badge, from a bundle, a registry or a file alone; stays open while something is looked up."""
    if wish.bundle_path is not None:
        return _of_bundle(wish.bundle_path, wish.claim or "", wish.trust)
    if wish.badge_json is not None and wish.registry_url is None:
        return _of_file(wish.badge_json)
    return _of_registry(wish)


@contextmanager
def _of_file(path: Path) -> Iterator[ClaimContext]:
    from moireid.badge import load_badge
    from moireid.provenance import ClaimedBadge
    from moireid.verifier.report.circumstances import Circumstances

    yield ClaimContext(ClaimedBadge(load_badge(path)), lambda document: Circumstances(datetime.now(UTC)))


@contextmanager
def _of_registry(wish: ClaimWish) -> Iterator[ClaimContext]:
    """The badge of a claim; for a file, the registry's own badge if the registry holds it."""
    from moireid.badge import load_badge
    from moireid.registry import claimed, claimed_by_file, open_registry

    badge = load_badge(wish.badge_json) if wish.badge_json is not None else None
    with open_registry(wish.registry_url, create=False) as registry:
        standing = registry.standing(wish.trust)
        report_standing(standing)
        require(wish.witness_check, registry)
        found = claimed(registry, wish.claim or "") if badge is None else claimed_by_file(registry, badge)

    def look_up(document: Mapping[str, Any]) -> Circumstances:
        with open_registry(wish.registry_url, create=False) as registry:
            # Another one may be there by now, and the user may remember none.
            registry.standing(wish.trust or standing.fingerprint)
            require(wish.witness_check, registry)
            return known_by(registry, standing, document)

    yield ClaimContext(replace(found, provenance=replace(found.provenance, standing=standing)), look_up)


@contextmanager
def _of_bundle(path: Path, claim: str, trust: str | None) -> Iterator[ClaimContext]:
    from moireid.registry.bundle.held import Bundle
    from moireid.verifier.report.circumstances import Circumstances, read_id

    with Bundle(path, trust) as bundle:
        report_standing(bundle.standing)

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            # If the claimed seal opened, the holder is known already.
            other = read_id(document) if document["identity"]["verdict"] == "mismatch" else None
            read = bundle.holder_of(other) if bundle.opens_soon else None
            return Circumstances(
                datetime.now(UTC),
                read=read,
                standing=bundle.standing,
                looked_up=bundle.opens_soon,
                registry=str(path),
            )

        yield ClaimContext(bundle.claimed(claim), look_up)


def known_by(registry: Registry, standing: Standing, document: Mapping[str, Any]) -> Circumstances:
    """What a registry says about a report: who holds the badge that was read, and which authority signed it."""
    from moireid.registry import holder_of
    from moireid.verifier.report.circumstances import Circumstances, read_id

    read = holder_of(registry, read_id(document))
    return Circumstances(datetime.now(UTC), read=read, standing=standing, registry=registry.shown_url)


Progress = Callable[[int, int | None], None]
Scores = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Outcome:
    """A report as JSON; and the pictures and signals for its pages, made when they are asked for."""

    document: dict[str, Any]
    drawn: Callable[[], tuple[Pictures, str]]


def claim_held(wish: VerifyOptions, found: ClaimedBadge) -> Claim:
    """What the film is checked against."""
    from moireid.verifier import Claim
    from moireid.verifier.limits import MIN_COVER_SHARE

    return Claim.of(
        found,
        focal_px=wish.focal_px,
        camera=camera_held(wish.camera_file, wish.focal_px),
        require_original=wish.require_original,
        cover_share=MIN_COVER_SHARE if wish.cover_share is None else wish.cover_share,
        photographs=wish.photographs or 0,
        level=wish.level,
    )


def judged(wish: VerifyOptions, found: ClaimedBadge, scores: Scores, reader: Reader, progress: Progress) -> Outcome:
    """The outcome of a film.

    Convention: claim, registry, and how the film was read are stated by this process; what reads the film only reports
    what it shows.
    """
    from moireid.attest.film_credentials import with_carried
    from moireid.reading.film_reports import judged_film

    made, standing = judged_film(_order(wish, found, scores), reader, progress), found.provenance.standing
    own = {
        "registry": standing.to_json() if standing else None,
        "claim_source": found.provenance.source,
        "badge": found.to_json(),
    }
    document = made.report | own
    if not wish.published:
        document = with_carried(document, wish.video)
    return Outcome(document, lambda: (made.pictures, made.signals))


def _order(wish: VerifyOptions, found: ClaimedBadge, scores: Scores) -> JudgingOrder:
    from moireid.reading.film_orders import JudgingOrder, published_method

    baseline = published_method() if wish.published or wish.corners_given is not None else None
    corners = None if baseline is None or wish.corners_given is None else baseline.corners_from(wish.corners_given)
    return JudgingOrder(
        wish.video,
        claim_held(wish, found),
        found.barred,
        wish.overlap,
        scores,
        wish.report_folder is not None,
        wish.pipeline,
        corners,
    )


def plan_pages(folder: Path | None, *, overwrite: bool, kept: Sequence[Path | None]) -> None:
    """Raise SpecError if a page would replace a file, or one of those that are read."""
    if folder is not None:
        from moireid.files import planned
        from moireid.verifier.report.report_page import report_paths

        planned(report_paths(folder), overwrite=overwrite, kept=kept)


def write_pages_of(
    outcome: Outcome, signing: Signing | None, known: Circumstances, wish: VerifyOptions
) -> dict[str, Any]:
    """Sign the report if asked for, then write its pages; returns the report as it was signed."""
    document = outcome.document
    if signing is not None:
        document = signing.write(document, wish.video)
    if wish.report_folder is not None:
        from moireid.verifier.report.report_page import write_pages

        page, *_ = write_pages(document, *outcome.drawn(), known, wish.report_folder, overwrite=wish.overwrite)
        say(f"report: {page}")
    return document


MARKS = {"pass": "✓", "fail": "✗", "undecided": "?", "note": "·"}
#: Colours of a terminal, by what a headline or a finding says.
COLOURS = {"accept": "green", "pass": "green", "reject": "red", "fail": "red"}
COLOURS |= {"inconclusive": "yellow", "undecided": "yellow"}
#: Findings name no options, as pages show them too; these are the options that help, by code.
OPTIONS = {
    "focal": "--focal-px",
    "gain": "--focal-px, or enroll --capture",
    "built": "--no-require-original, or enroll --capture",
    "copyable": "enroll --capture",
    "cover": "--cover",
    "photographs": "--photographs",
    "level": "--level, enroll --capture, or watch --challenge",
    "corners": "--pipeline published",
}


def show_verdict(
    word: str, document: Mapping[str, Any], known: Circumstances, headline: Headline | None = None
) -> None:
    """Print the headline, what it means and what to do; then the findings, failures first, with the passes in one line.

    headline: None for that of a film.
    """
    from moireid.verifier.report.finding_words import sorted_findings
    from moireid.verifier.report.headline import headline_of
    from moireid.verifier.report.live_receipt import receipt_of
    from moireid.verifier.report.rival_table import odds_line
    from moireid.verifier.report.seconds import seconds_of

    headline, found = headline or headline_of(document, known), sorted_findings(document["reasons"])
    echo(f": {headline.title}", lead=word, colour=COLOURS[headline.colour])
    echo(headline.text)
    echo(f"What to do: {headline.advice}")
    if (seconds := seconds_of(document)) is not None:
        echo(f"Seconds: {seconds.text}")
    if odds := odds_line(document):
        echo(f"Odds: {odds}")
    for finding in found.first:
        option = OPTIONS.get(finding["code"], "") if finding["level"] in ("undecided", "note") else ""
        mark, colour = MARKS[finding["level"]], COLOURS.get(finding["level"])
        echo(f" {finding['text']}{f' ({option})' if option else ''}", lead=f"  {mark}", colour=colour)
    if found.hold:
        codes = ", ".join(dict.fromkeys(finding["code"] for finding in found.hold))
        echo(f" holds: {codes}", lead=f"  {MARKS['pass']}", colour=COLOURS["pass"])
    for one in document.get("live_checks", []):
        echo(f"  · {receipt_of(one).words}")
    for one in document.get("detectors", []):
        echo(f"  · Detector {one['name']} gives {one['score']:g}; that is no part of the verdict.")


@click.command("verify")
@click.argument("video", type=click.Path(path_type=Path))
@verify_options
@signing_options
@friendly
@witness_check
def verify_command(**given: Any) -> None:
    """Check a film: is the badge real, and is it the claimed one?

    The fringes must move as the optics of a real badge demand, and the badge must spell the claimed identity. Say whose
    badge it should be with --claim, or give its file with --badge.

    Exit code 0: accepted; 1: rejected; 2: bad input; 3: inconclusive.
    """
    from moireid.verifier.report.live_receipt import attached, check_belongs, load_receipt

    wish = VerifyOptions(**given)
    check_wish(wish)
    scores = detectors_from(wish.detectors)
    receipts = [load_receipt(path) for path in wish.receipt_files]
    kept = [*files_read(wish), wish.video, wish.key_file, *wish.receipt_files]
    signing = planned_signing(
        wish.video, wish.key_file, wish.attest_file, wish.timestamp_url, wish.form, overwrite=wish.overwrite, kept=kept
    )
    films = sealed_reader([wish.video], unsealed=wish.unsealed)
    with films as reader, asked_of(wish) as asked:
        for receipt in receipts:
            check_belongs(receipt, asked.found, wish.video)
        plan_pages(wish.report_folder, overwrite=wish.overwrite, kept=kept)
        with progress_bar("reading the film") as progress:
            outcome = judged(wish, asked.found, scores, reader, progress)
        outcome = replace(outcome, document=attached(outcome.document, receipts))
        known = asked.known(outcome.document, wish.claim)
    document = write_pages_of(outcome, signing, known, wish)
    if wish.as_json:
        show_json(document)
    else:
        show_verdict(document["verdict"].upper(), document, known)
    sys.exit(VERDICT_EXIT[document["verdict"]])
