"""identify: whose badge a film shows, of all in a registry or a bundle of it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    trust_option,
)
from moireid.cli.sealed_reader import sealed_reader, unsealed_option
from moireid.cli.verify.verify_cmd import LookUp, known_by, show_verdict
from moireid.cli.verify.verify_options import focal_option
from moireid.cli.witness_options import WitnessCheck, require, witness_check
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.provenance import Standing
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.session.identify import EnrolledPeople


@dataclass(frozen=True)
class _SearchScope:
    """The people who may be found, and look-ups for the one who was found."""

    standing: Standing
    layouts: list[Badge]
    enrolled: EnrolledPeople
    name: Callable[[str | None], str | None]
    look_up: LookUp
    #: Adds the notes on the badge that was found to the document.
    noted: Callable[[dict[str, Any], str | None], dict[str, Any]]


@click.command("identify")
@click.argument("video", type=click.Path(path_type=Path))
@registry_option
@bundle_option
@trust_option
@focal_option
@camera_option
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
    unsealed: bool,
    as_json: bool,
) -> None:
    """Find out whose badge a film shows.

    Everyone in the registry, or in the bundle, is considered, and no claim is needed.

    Exit code 0: found; 1: no one enrolled; 2: bad input; 3: inconclusive.
    """
    from moireid.reading.film_orders import IdentifyingOrder
    from moireid.reading.film_reports import identified_film

    if bundle_path is not None and registry_url is not None:
        raise SpecError("--bundle replaces --registry; leave one of them out")
    camera = camera_held(camera_file, focal_px)
    opened = _of_registry(registry_url, trust, witness_check) if bundle_path is None else _of_bundle(bundle_path, trust)
    films = sealed_reader([video], unsealed=unsealed)
    with films as reader, opened as asked, progress_bar("reading the film") as progress:
        report_standing(asked.standing)
        order = IdentifyingOrder(video, asked.layouts, focal_px, camera)
        outcome = identified_film(order, reader, progress, partial(answer_to, enrolled=asked.enrolled, film=video))
        found_id = outcome["found_id"]
        own = {"found_name": asked.name(found_id), "registry": asked.standing.to_json()}
        document = asked.noted(outcome | own, found_id)
        known = asked.look_up(document)
    if as_json:
        show_json(document)
    else:
        show_verdict(document["finding"].upper(), document, known)
    sys.exit({"found": ACCEPT, "nobody": REJECT, "inconclusive": INCONCLUSIVE}[document["finding"]])


def answer_to(question: object, enrolled: EnrolledPeople, film: Path) -> Any:
    """The answer to a question of the process that reads the film.  Raises: MediaError if it is none."""
    from moireid.reading.answers import RegistryQuestion, checked

    asked = checked(question, RegistryQuestion, film)
    return enrolled.holds(asked.holds) if asked.holds is not None else enrolled.alike(asked.alike or {})


@contextmanager
def _of_registry(registry_url: str | None, trust: str | None, witnesses: WitnessCheck | None) -> Iterator[_SearchScope]:
    from moireid.registry import People, open_registry
    from moireid.verifier.session.claim import with_badge_notes

    with open_registry(registry_url, create=False) as registry:
        standing, people = registry.standing(trust), People(registry)
        require(witnesses, registry)

        def noted(document: dict[str, Any], found_id: str | None) -> dict[str, Any]:
            record = registry.by_id(found_id or "")
            if record is None:
                return document
            return with_badge_notes(document, record.badge, measured=record.as_built is not None)

        yield _SearchScope(
            standing,
            registry.layouts(),
            people,
            people.name,
            lambda document: known_by(registry, standing, document),
            noted,
        )


@contextmanager
def _of_bundle(path: Path, trust: str | None) -> Iterator[_SearchScope]:
    """Each identity that is read is tried on every seal, however many there are, as identification needs it."""
    from moireid.registry.bundle.held import Bundle, BundlePeople
    from moireid.verifier.report.circumstances import Circumstances, read_id
    from moireid.verifier.session.claim import with_badge_notes

    with Bundle(path, trust) as bundle:
        people = BundlePeople(bundle)

        def name(badge_id: str | None) -> str | None:
            holder = people.holder(badge_id) if badge_id else None
            return holder.name if holder else None

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            read = read_id(document)
            holder = people.holder(read) if isinstance(read, str) else None
            return Circumstances(datetime.now(UTC), read=holder, standing=bundle.standing, registry=str(path))

        def noted(document: dict[str, Any], found_id: str | None) -> dict[str, Any]:
            if found_id is None:
                return document
            found = bundle.claimed(found_id)
            # The bundle seals its identities, but this one has been read.
            return with_badge_notes(document, replace(found.badge, id=found_id), measured=found.as_built is not None)

        yield _SearchScope(bundle.standing, bundle.layouts(), people, name, look_up, noted)
