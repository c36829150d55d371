"""How a registry, a bundle or a file is asked: for the badge of a claim, and for all people who may be found.

The process that reads the film learns the claimed badge alone.  Holders are looked up once the film is judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

from moireid.api.places import Place, opened, warn_of
from moireid.badge import Badge, load_badge
from moireid.files import AnyPath, as_path
from moireid.provenance import ClaimedBadge, Standing
from moireid.registry import People, Registry, claimed, claimed_by_file, holder_of
from moireid.registry.bundle.held import Bundle, BundlePeople
from moireid.verifier.report.circumstances import Circumstances, read_id
from moireid.verifier.session.claim import with_badge_notes
from moireid.verifier.session.identify import EnrolledPeople

#: From a report's JSON to the circumstances of its check.
LookUp = Callable[[Mapping[str, Any]], Circumstances]


@contextmanager
def claim_of_badge(badge: Badge | AnyPath, registry: Place, trust: str | None) -> Iterator[tuple[ClaimedBadge, LookUp]]:
    """The badge itself; with a registry that holds it, the registry's own record of it."""
    own = badge if isinstance(badge, Badge) else load_badge(badge)
    if registry is None:
        yield ClaimedBadge(own), lambda document: Circumstances(datetime.now(UTC))
        return
    with _asked(registry, trust) as (held, standing):
        yield _standing(claimed_by_file(held, own), standing), lambda document: _known_by(held, standing, document)


@contextmanager
def claim_of_name(claim: str, registry: Place, trust: str | None) -> Iterator[tuple[ClaimedBadge, LookUp]]:
    """The badge that a name or an id means in a registry."""
    with _asked(registry, trust) as (held, standing):
        yield _standing(claimed(held, claim), standing), lambda document: _known_by(held, standing, document)


@contextmanager
def claim_in_bundle(claim: str, bundle: AnyPath, trust: str | None) -> Iterator[tuple[ClaimedBadge, LookUp]]:
    """The badge that a name or an id means in a bundle."""
    with Bundle(as_path(bundle), trust) as held:
        warn_of(held.standing)

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            # If the claimed seal opened, the holder is known already.
            other = read_id(document) if document["identity"]["verdict"] == "mismatch" else None
            read = held.holder_of(other) if held.opens_soon else None
            known = Circumstances(datetime.now(UTC), read=read, standing=held.standing, registry=str(bundle))
            return replace(known, looked_up=held.opens_soon)

        yield held.claimed(claim), look_up


@dataclass(frozen=True)
class SearchScope:
    """The people who may be found in a film.

    layouts: one badge of each layout; name: of who holds an id; note: adds to a report's JSON who else could have the
    badge that was found.
    """

    standing: Standing
    layouts: list[Badge]
    enrolled: EnrolledPeople
    name: Callable[[str], str | None]
    note: Callable[[dict[str, Any], str], dict[str, Any]]
    look_up: LookUp

    def answer(self, question: Any) -> Any:
        """The answer to a question of the process that reads the film; None to what is none."""
        match question:
            case {"holds": str(badge_id)}:
                return self.enrolled.holds(badge_id)
            case {"alike": dict(parts)}:
                return self.enrolled.alike({int(place): str(part) for place, part in parts.items()})
        return None


@contextmanager
def people_of_registry(registry: Place, trust: str | None) -> Iterator[SearchScope]:
    """Everyone in a registry."""
    with _asked(registry, trust) as (held, standing):
        people = People(held)

        def note(document: dict[str, Any], found_id: str) -> dict[str, Any]:
            record = held.by_id(found_id)
            if record is None:
                return document
            return with_badge_notes(document, record.badge, measured=record.as_built is not None)

        yield SearchScope(
            standing, held.layouts(), people, people.name, note, lambda document: _known_by(held, standing, document)
        )


@contextmanager
def people_of_bundle(bundle: AnyPath, trust: str | None) -> Iterator[SearchScope]:
    """Everyone in a bundle: each identity that is read is tried on every seal, however many there are."""
    with Bundle(as_path(bundle), trust) as held:
        warn_of(held.standing)
        people = BundlePeople(held)

        def name(badge_id: str) -> str | None:
            holder = people.holder(badge_id)
            return holder.name if holder else None

        def note(document: dict[str, Any], found_id: str) -> dict[str, Any]:
            found = held.claimed(found_id)
            # The bundle seals its identities, but this one has been read.
            return with_badge_notes(document, replace(found.badge, id=found_id), measured=found.as_built is not None)

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            read = read_id(document)
            holder = people.holder(read) if isinstance(read, str) else None
            return Circumstances(datetime.now(UTC), read=holder, standing=held.standing, registry=str(bundle))

        yield SearchScope(held.standing, held.layouts(), people, name, note, look_up)


@contextmanager
def _asked(registry: Place, trust: str | None) -> Iterator[tuple[Registry, Standing]]:
    with opened(registry) as held:
        standing = held.standing(trust)
        warn_of(standing)
        yield held, standing


def _standing(found: ClaimedBadge, standing: Standing) -> ClaimedBadge:
    return replace(found, provenance=replace(found.provenance, standing=standing))


def _known_by(registry: Registry, standing: Standing, document: Mapping[str, Any]) -> Circumstances:
    """What a registry says about a report: who holds the badge that was read, and which authority signed it."""
    read = holder_of(registry, read_id(document))
    return Circumstances(datetime.now(UTC), read=read, standing=standing, registry=registry.shown_url)
