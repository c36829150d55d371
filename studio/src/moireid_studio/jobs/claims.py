"""What a job's process gets, from the visitor's wish: the claimed badge, and what the registry knows of it now.

The wish is looked up again as the job begins.  So a badge that was revoked meanwhile counts as revoked.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.lenticule import view_law
from moireid.provenance import Seal, Standing
from moireid.question import KnownCamera, Question
from moireid.reading.film_orders import identify_film, judge_film, measure_captures
from moireid.registry import Registry, claimed, claimed_by_file
from moireid_studio.jobs.task import Law, Task
from moireid_studio.problems import Refusal
from moireid_studio.store.job import Job

#: At most this many laws are given to a film's process: those of a claimed badge, or of the registry's layouts.
MOST_LAWS = 8


def prepared(job: Job, registry: Registry, trust: str | None, maker: Callable[[], Mapping[str, Any]]) -> Task:
    """What the process of a job gets; maker: gives the registry's place and keys to those who make badges.

    Raises: Refusal where the claim no longer means anyone; RegistryError.
    """
    wish, film, task = job.wish, Path(job.video), partial(Task, job.kind, job.folder, job.video)
    focal_px = wish.get("focal_px")
    camera = None if focal_px is None else KnownCamera(focal_px)
    if job.kind == "verify":
        found, laws = note_claim(job, registry, wish, registry.standing(trust))
        asked = replace(found, camera=camera, cover_share=wish["cover"], level=wish["level"])
        asked = asked if wish["ids"] else sealed(asked)
        return task(partial(judge_film, film=film, question=asked, pictures=wish["report"]), laws)
    if job.kind == "identify":
        job.standing, layouts = registry.standing(trust), registry.layouts()
        return task(partial(identify_film, film=film, layouts=layouts, camera=camera), laws_of(layouts))
    if job.kind == "capture":
        return task(partial(measure_captures, films=[film], badge=badge_from_json(wish["badge_json"])))
    return task(arguments=dict(wish) | dict(maker()))


def note_claim(job: Job, registry: Registry, wish: Mapping[str, Any], standing: Standing) -> tuple[Question, list[Law]]:
    """The badge that a wish claims, by name or id (`claim`) or by its file (`badge`), which is noted in the job; ids:
    whether those who ask may learn other ids.

    Raises: Refusal as `find_claimed`; RegistryError, SpecError.
    """
    if wish.get("claim") is not None:
        found = find_claimed(registry, wish["claim"], ids=wish["ids"])
        alike = found.provenance.alike
    else:
        found = claimed_by_file(registry, badge_from_json(wish["badge"]))
        alike = _names(found.provenance.alike, ids=wish["ids"])
    found = replace(found, provenance=replace(found.provenance, standing=standing, alike=alike))
    job.standing, job.claimed_id = standing, found.badge.id
    job.claim_source, job.barred = found.provenance.source, found.barred
    # The law of a visitor's own badge file is traced in the film's process, which has limits.
    return found, laws_of([found.badge]) if found.provenance.source == "registry" else []


def sealed(found: Question) -> Question:
    """An enrolled badge for the film of a visitor who may not issue: its report then shows no identity that the film
    itself does not show, neither as digits nor as lines in a plot.
    """
    if found.provenance.source != "registry" or found.badge.id is None:
        return found
    badge = replace(specimen_of(found.badge), name=found.badge.name)
    built = None if found.as_built is None else replace(found.as_built, badge_id="")
    earlier = tuple(replace(one, as_built=replace(one.as_built, badge_id="")) for one in found.earlier)
    seal = Seal.of(found.badge.id, secrets.token_bytes(16))
    return replace(found, badge=badge, badge_id=None, as_built=built, earlier=earlier, seal=seal)


def find_claimed(registry: Registry, claim: str, *, ids: bool) -> Question:
    """Like `claimed`; ids: whether those who ask may learn other ids than the claimed one.

    Raises: Refusal 404 where the claim means no one, 409 where it means several people.
    """
    try:
        found = claimed(registry, claim)
    except RegistryError as error:
        known = error.details.get("ids")
        if known == []:
            text = f"No one named {claim[:80]!r} is in the registry, and no badge has such an id."
            if alike := error.details.get("alike"):
                names = _names(alike, ids=ids)  # type: ignore[arg-type]
                text += f" The name looks like {' and '.join(names)}, but is written in other letters."
            raise Refusal(404, "no_claim", text) from error
        if known and not ids:
            count = len(known)  # type: ignore[arg-type]
            text = f"{count} badges are meant by {claim[:80]!r}; claim the id that the person or an issuer gave you."
            raise Refusal(409, "ambiguous", text) from error
        if known:
            raise Refusal(409, "ambiguous", f"{str(error)[:1].upper()}{str(error)[1:]}.") from error
        raise
    alike = _names(found.provenance.alike, ids=ids)
    return replace(found, provenance=replace(found.provenance, alike=alike))


def laws_of(badges: Sequence[Badge]) -> list[Law]:
    """The laws of the registry's badges, traced here once, so that no film's process must trace them again."""
    pairs = {(badge.lens, grating.pitch_mm) for badge in badges for grating in badge.gratings}
    return [(lens, pitch_mm, view_law(lens, pitch_mm)) for lens, pitch_mm in list(pairs)[:MOST_LAWS]]


def _names(alike: Sequence[str], *, ids: bool) -> tuple[str, ...]:
    """Names that look like the claimed one, each "NAME (ID)"; without the ids for those who may not learn them."""
    return tuple(alike) if ids else tuple(one.rpartition(" (")[0] for one in alike)
