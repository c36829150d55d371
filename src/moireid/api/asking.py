"""How a registry, a bundle or a file is asked: for the badge of a claim, and for all people who may be found.

The commands ask so, too.  The process that reads the film learns the claimed badge alone.  Holders are looked up once
the film is judged.  A registry's packages are loaded only where one is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from moireid.badge import Badge, load_badge
from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.provenance import FROM_FILE, BadgeHolder, Standing
from moireid.question import KnownCamera, Question
from moireid.verifier.report.circumstances import Circumstances, read_id

if TYPE_CHECKING:
    from moireid.api.places import Place
    from moireid.reading.film_orders import Progress
    from moireid.reading.film_reader import Reader
    from moireid.registry import Registry
    from moireid.registry.bundle.held import Bundle

#: From a report's JSON to the circumstances of its check.
LookUp = Callable[[Mapping[str, Any]], Circumstances]
#: What is asked of a film, and how its report is looked up where the claim was.
ClaimContext = tuple[Question, LookUp]
#: Raises an error where a registry or bundle does not hold what is asked of it.
Require = Callable[["Registry | Bundle"], object]


@contextmanager
def asked(
    registry: Place,
    bundle: AnyPath | None,
    trust: str | None,
    note: Callable[[Standing], object],
    require: Require | None = None,
) -> Iterator[tuple[Registry | Bundle, Standing]]:
    """A registry or a bundle of one, open.

    Parameters: trust: the fingerprint of the one authority that counts; note: takes what a user should know of it;
        require: raises an error where more is asked of a registry or bundle than holds.
    Raises: SpecError where both are given.
    """
    from moireid.api.places import opened
    from moireid.registry.bundle.held import Bundle

    if bundle is not None and registry is not None:
        raise SpecError("bundle= replaces registry=; leave one of them out")
    with opened(registry) if bundle is None else Bundle(as_path(bundle), trust) as held:
        standing = held.standing if isinstance(held, Bundle) else held.standing(trust)
        note(standing)
        if require is not None:
            require(held)
        yield held, standing


@contextmanager
def claim_context(
    claim: str | None,
    badge: Badge | AnyPath | None,
    registry: Place,
    bundle: AnyPath | None,
    trust: str | None,
    note: Callable[[Standing], object],
    require: Require | None = None,
) -> Iterator[ClaimContext]:
    """Where a claimed badge is looked up; trust, note, require: as `asked`.

    Raises: SpecError unless there is one claim and one place.
    """
    if bundle is not None and (registry is not None or claim is None):
        raise SpecError("bundle= replaces registry=, and needs claim=; leave the other one out")
    if (claim is None) == (badge is None):
        raise SpecError("give either claim=, a name or an id, or badge=, a badge.json")
    own = None
    if badge is not None:
        # What it wears is of no use to the process that reads the film.
        own = replace(badge, look=None) if isinstance(badge, Badge) else load_badge(badge)
    if own is not None and registry is None:
        if trust is not None or require is not None:
            name = "trust=" if trust is not None else "witness_keys="
            raise SpecError(
                f"{name} is of a registry, and none is asked with badge= alone; add registry=, or leave it out"
            )
        yield Question(own, own.id, provenance=FROM_FILE), lambda document: Circumstances(datetime.now(UTC))
        return
    from moireid.registry import claimed_by_file
    from moireid.registry.bundle.held import Bundle

    with asked(registry, bundle, trust, note, require) as (held, standing):
        if own is not None and not isinstance(held, Bundle):
            found = claimed_by_file(held, own)
        else:
            found = _claimed(held, claim or "")

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            # If the claimed identity was read, the holder is known already.
            other = read_id(document) if document["identity"]["verdict"] == "mismatch" else None
            return Circumstances(
                datetime.now(UTC),
                claim=claim,
                barred=found.barred,
                read=holder_in(held)(other) if isinstance(other, str) else None,
                standing=standing,
                registry=_name(held),
            )

        yield replace(found, provenance=replace(found.provenance, standing=standing)), look_up


def search(
    held: Registry | Bundle,
    standing: Standing,
    film: Path,
    camera: KnownCamera | None,
    track: int | None,
    reader: Reader,
    progress: Progress,
) -> tuple[dict[str, Any], Circumstances]:
    """Whose badge of a registry or a bundle a film shows, as JSON, and how it was looked up.

    Raises: MoireIdError as `identified_film`.
    """
    from moireid.reading.film_reports import identified_film

    document = identified_film(film, held.layouts(), camera, track, reader, progress)
    document = with_holder(document, held) | {"registry": standing.to_json()}
    read = read_id(document)
    known = holder_in(held)(read) if isinstance(read, str) else None
    return document, Circumstances(datetime.now(UTC), read=known, standing=standing, registry=_name(held))


def with_holder(document: dict[str, Any], held: Registry | Bundle) -> dict[str, Any]:
    """What a film's identification is to the registry or bundle: found is who is enrolled there, by name.

    Raises: RegistryError.
    """
    from moireid.registry import holds
    from moireid.verifier.session.claim import with_badge_notes
    from moireid.verifier.session.identify import of_enrolled

    holder = holder_in(held)
    document = of_enrolled(document, partial(holds, holder))
    if (found_id := document["found_id"]) is None:
        return document | {"found_name": None}
    found = holder(found_id)
    document |= {"found_name": found.name if found else None}
    return with_badge_notes(document, measured=_claimed(held, found_id).as_built is not None)


def _claimed(held: Registry | Bundle, claim: str) -> Question:
    from moireid.registry import Registry, claimed

    return claimed(held, claim) if isinstance(held, Registry) else held.claimed(claim)


def holder_in(held: Registry | Bundle) -> Callable[[str], BadgeHolder | None]:
    """From an id to its holder in a registry or a bundle."""
    from moireid.registry import Registry, holder_of

    return partial(holder_of, held) if isinstance(held, Registry) else held.holder_of


def _name(held: Registry | Bundle) -> str:
    """The name of a registry or a bundle, for reports, which others read: no folders."""
    from moireid.registry import Registry

    return Path(urlsplit(held.shown_url).path).name if isinstance(held, Registry) else held.path.name
