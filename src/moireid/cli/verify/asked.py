"""The badge that is claimed, and what a registry, a bundle or nobody knows of a report.

A look-up is made when the film is judged, by this process: that which decodes the film is told of the claimed badge
alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from moireid.cli.common import tell_standing
from moireid.cli.verify.options import ClaimWish, Wish

if TYPE_CHECKING:
    from moireid.provenance import Claimed, Standing
    from moireid.registry import Registry
    from moireid.verifier.report.circumstances import Circumstances

#: From a report's JSON to what is known of it.
LookUp = Callable[[Mapping[str, Any]], "Circumstances"]


@dataclass(frozen=True)
class Asked:
    """A claimed badge, with the standing of the registry or bundle that was asked, and a look-up of reports there."""

    found: Claimed
    look_up: LookUp

    @property
    def standing(self) -> Standing | None:
        """None where neither was asked."""
        return self.found.provenance.standing

    def known(self, document: Mapping[str, Any], claim: str | None) -> Circumstances:
        """How the check of a report was made; claim: as it was typed."""
        return replace(self.look_up(document), claim=claim, barred=self.found.barred)


def files_read(wish: Wish) -> list[Path | None]:
    """The files that are read for a wish, which no output may replace."""
    found = [wish.video, wish.key_file, wish.bundle_path, wish.badge_json]
    if wish.registry_url is None and (wish.claim is None or wish.bundle_path is not None):
        return found
    from moireid.registry.url import own_file

    return [*found, own_file(wish.registry_url)]


def asked_of(wish: ClaimWish) -> AbstractContextManager[Asked]:
    """The claimed badge: by a bundle, by a registry, or by a file alone; open as long as something is looked up."""
    if wish.bundle_path is not None:
        return _of_bundle(wish.bundle_path, wish.claim or "", wish.trust)
    if wish.badge_json is not None and wish.registry_url is None:
        return _of_file(wish.badge_json)
    return _of_registry(wish)


@contextmanager
def _of_file(path: Path) -> Iterator[Asked]:
    from moireid.badge import load_badge
    from moireid.provenance import Claimed
    from moireid.verifier.report.circumstances import Circumstances

    yield Asked(Claimed(load_badge(path)), lambda document: Circumstances(datetime.now(UTC)))


@contextmanager
def _of_registry(wish: ClaimWish) -> Iterator[Asked]:
    """By a claim; or of a file the registry's own badge, where it holds that."""
    from moireid.badge import load_badge
    from moireid.registry import claimed, claimed_by_file, open_registry

    badge = load_badge(wish.badge_json) if wish.badge_json is not None else None
    with open_registry(wish.registry_url, create=False) as registry:
        standing = registry.standing(wish.trust)
        tell_standing(standing)
        found = claimed(registry, wish.claim or "") if badge is None else claimed_by_file(registry, badge)

    def look_up(document: Mapping[str, Any]) -> Circumstances:
        with open_registry(wish.registry_url, create=False) as registry:
            return known_by(registry, standing, document)

    yield Asked(replace(found, provenance=replace(found.provenance, standing=standing)), look_up)


@contextmanager
def _of_bundle(path: Path, claim: str, trust: str | None) -> Iterator[Asked]:
    from moireid.registry.bundle.held import Bundle
    from moireid.verifier.report.circumstances import Circumstances, read_id

    with Bundle(path, trust) as bundle:
        tell_standing(bundle.standing)

        def look_up(document: Mapping[str, Any]) -> Circumstances:
            # Where the claimed seal opened, the holder is told already.
            other = read_id(document) if document["identity"]["verdict"] == "mismatch" else None
            read = bundle.holder_of(other) if bundle.opens_soon else None
            return Circumstances(
                datetime.now(UTC),
                read=read,
                standing=bundle.standing,
                looked_up=bundle.opens_soon,
                registry=str(path),
            )

        yield Asked(bundle.claimed(claim), look_up)


def known_by(registry: Registry, standing: Standing, document: Mapping[str, Any]) -> Circumstances:
    """What a registry knows of a report: who holds the badge that was read, and whose word that is."""
    from moireid.registry import holder_of
    from moireid.verifier.report.circumstances import Circumstances, read_id

    read = holder_of(registry, read_id(document))
    return Circumstances(datetime.now(UTC), read=read, standing=standing, registry=registry.shown_url)
