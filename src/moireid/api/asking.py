"""How a registry, a bundle or a file is asked: for the badge of a claim, and for all people who may be found.

The commands ask so, too.  The process that reads the film learns the claimed badge alone.  Holders are looked up once
the film is judged.  A registry's packages are loaded only where one is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from moireid.badge import Badge, load_badge
from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.provenance import FROM_FILE, Standing
from moireid.question import KnownCamera, Question
from moireid.verifier.report.circumstances import Circumstances, read_id

if TYPE_CHECKING:
    from moireid.api.places import Place
    from moireid.reading.film_orders import Progress
    from moireid.reading.film_reader import Reader
    from moireid.registry import People, Registry
    from moireid.registry.bundle.held import Bundle

#: From a report's JSON to the circumstances of its check.
LookUp = Callable[[Mapping[str, Any]], Circumstances]


@dataclass(frozen=True)
class AskingTerms:
    """How a registry or bundle is asked.

    trust: the fingerprint of the one authority that counts; note: takes what a user should know of it; require: raises
    an error where more is asked of a registry or bundle than holds.
    """

    trust: str | None
    note: Callable[[Standing], object]
    require: Callable[[Registry | Bundle], object] | None = None

    def check(self, held: Registry | Bundle, standing: Standing) -> None:
        """Note what is to be known of what was opened, and raise an error where more is asked of it than holds."""
        self.note(standing)
        if self.require is not None:
            self.require(held)


#: What is asked of a film, and how its report is looked up where the claim was.
ClaimContext = tuple[Question, LookUp]


def claim_context(
    claim: str | None, badge: Badge | AnyPath | None, registry: Place, bundle: AnyPath | None, terms: AskingTerms
) -> AbstractContextManager[ClaimContext]:
    """Where a claimed badge is looked up.  Raises: SpecError unless there is one claim and one place."""
    if bundle is not None and (registry is not None or claim is None):
        raise SpecError("bundle= replaces registry=, and needs claim=; leave the other one out")
    if badge is not None and registry is None and (terms.trust is not None or terms.require is not None):
        name = "trust=" if terms.trust is not None else "witness_keys="
        raise SpecError(f"{name} is of a registry, and none is asked with badge= alone; add registry=, or leave it out")
    if claim is not None and badge is None:
        return claim_of_name(claim, registry, terms) if bundle is None else claim_in_bundle(claim, bundle, terms)
    if badge is not None and claim is None:
        return claim_of_badge(badge, registry, terms)
    raise SpecError("give either claim=, a name or an id, or badge=, a badge.json")


@contextmanager
def claim_of_badge(badge: Badge | AnyPath, registry: Place, terms: AskingTerms) -> Iterator[ClaimContext]:
    """The badge itself; with a registry that holds it, the registry's own record of it."""
    # What it wears is of no use to the process that reads the film.
    own = replace(badge, look=None) if isinstance(badge, Badge) else load_badge(badge)
    if registry is None:
        yield Question(own, own.id, provenance=FROM_FILE), lambda document: Circumstances(datetime.now(UTC))
        return
    from moireid.registry import claimed_by_file

    yield _claim_of(registry, terms, lambda held: claimed_by_file(held, own))


@contextmanager
def claim_of_name(claim: str, registry: Place, terms: AskingTerms) -> Iterator[ClaimContext]:
    """The badge that a name or an id means in a registry."""
    from moireid.registry import claimed

    yield _claim_of(registry, terms, lambda held: claimed(held, claim), claim)


def _claim_of(
    registry: Place, terms: AskingTerms, find: Callable[[Registry], Question], claim: str | None = None
) -> ClaimContext:
    """A registry's answer, which is closed while the film is read, and opened again to look the report up."""
    with _asked(registry, terms) as (held, standing):
        found = find(held)
    # Another one may be there by then, and the user may remember none.
    again = replace(terms, trust=terms.trust or standing.fingerprint, note=lambda standing: None)

    def look_up(document: Mapping[str, Any]) -> Circumstances:
        with _asked(registry, again) as (held, _):
            return replace(_known_by(held, standing, document), claim=claim, barred=found.barred)

    return replace(found, provenance=replace(found.provenance, standing=standing)), look_up


@contextmanager
def claim_in_bundle(claim: str, bundle: AnyPath, terms: AskingTerms) -> Iterator[ClaimContext]:
    """The badge that a name or an id means in a bundle."""
    with _opened(bundle, terms) as held:
        found = held.claimed(claim)

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            # If the claimed seal opened, the holder is known already.
            other = read_id(document) if document["identity"]["verdict"] == "mismatch" else None
            read = held.holder_of(other) if held.opens_soon else None
            return Circumstances(
                datetime.now(UTC),
                claim=claim,
                barred=found.barred,
                read=read,
                standing=held.standing,
                registry=held.path.name,
                looked_up=held.opens_soon,
            )

        yield found, look_up


@dataclass(frozen=True)
class SearchScope:
    """The people who may be found in a film.

    people: of a registry or a bundle; layouts: one badge of each layout; measured: whether the badge of an id was
    measured; source: the name of the registry or bundle.
    """

    standing: Standing
    people: People
    layouts: list[Badge]
    measured: Callable[[str], bool]
    source: str

    def search(
        self, film: Path, camera: KnownCamera | None, track: int | None, reader: Reader, progress: Progress
    ) -> tuple[dict[str, Any], Circumstances]:
        """What a film shows of them, as JSON, and how it was looked up.  Raises: MoireIdError as `identified_film`."""
        from moireid.reading.film_reports import identified_film
        from moireid.verifier.session.claim import with_badge_notes

        outcome = identified_film(film, self.layouts, camera, track, reader, progress, self.people)
        found_id = outcome["found_id"]
        document = outcome | {"found_name": self.people.name(found_id), "registry": self.standing.to_json()}
        if found_id is not None:
            document = with_badge_notes(document, measured=self.measured(found_id))
        read = read_id(document)
        holder = self.people.holder(read) if isinstance(read, str) else None
        return document, Circumstances(datetime.now(UTC), read=holder, standing=self.standing, registry=self.source)


def people_scope(registry: Place, bundle: AnyPath | None, terms: AskingTerms) -> AbstractContextManager[SearchScope]:
    """Everyone in a registry, or in a bundle.  Raises: SpecError where both are given."""
    if bundle is None:
        return people_of_registry(registry, terms)
    if registry is not None:
        raise SpecError("bundle= replaces registry=; leave one of them out")
    return people_of_bundle(bundle, terms)


@contextmanager
def people_of_registry(registry: Place, terms: AskingTerms) -> Iterator[SearchScope]:
    """Everyone in a registry."""
    from moireid.registry import people_of

    with _asked(registry, terms) as (held, standing):

        def measured(badge_id: str) -> bool:
            record = held.by_id(badge_id)
            return record is not None and record.as_built is not None

        yield SearchScope(standing, people_of(held), held.layouts(), measured, _source(held))


@contextmanager
def people_of_bundle(bundle: AnyPath, terms: AskingTerms) -> Iterator[SearchScope]:
    """Everyone in a bundle: each identity that is read is tried on every seal, however many there are."""
    from moireid.registry import People

    with _opened(bundle, terms) as held:

        def measured(badge_id: str) -> bool:
            return held.claimed(badge_id).as_built is not None

        yield SearchScope(held.standing, People(held.holder_of), held.layouts(), measured, held.path.name)


@contextmanager
def _opened(bundle: AnyPath, terms: AskingTerms) -> Iterator[Bundle]:
    from moireid.registry.bundle.held import Bundle

    with Bundle(as_path(bundle), terms.trust) as held:
        terms.check(held, held.standing)
        yield held


@contextmanager
def _asked(registry: Place, terms: AskingTerms) -> Iterator[tuple[Registry, Standing]]:
    from moireid.api.places import opened

    with opened(registry) as held:
        standing = held.standing(terms.trust)
        terms.check(held, standing)
        yield held, standing


def _known_by(registry: Registry, standing: Standing, document: Mapping[str, Any]) -> Circumstances:
    """What a registry says about a report: who holds the badge that was read, and which authority signed it."""
    from moireid.registry import holder_of

    read = holder_of(registry, read_id(document))
    return Circumstances(datetime.now(UTC), read=read, standing=standing, registry=_source(registry))


def _source(registry: Registry) -> str:
    """The name of a registry, for reports, which others read: no folders."""
    return Path(urlsplit(registry.shown_url).path).name
