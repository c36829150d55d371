"""From a visitor's form to a running job: the same for the API and for the pages."""

from __future__ import annotations

import math
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from fastapi import Request
from fastapi.concurrency import run_in_threadpool

from moireid.badge import Badge, badge_from_json
from moireid.errors import RegistryError
from moireid.idcodes import specimen_of
from moireid.lenticule import view_law
from moireid.provenance import Seal
from moireid.registry import Claimed, People, Registry, claimed, claimed_by_file
from moireid.verifier.limits import MIN_COVER_SHARE
from moireid.verifier.report.person import Claimed as Named
from moireid.web.auth.roles import Visitor
from moireid.web.jobs.queue import Job
from moireid.web.jobs.task import Law
from moireid.web.problems import Refusal
from moireid.web.studio import Studio, studio_of
from moireid.web.uploads import receive

#: Allowed focal lengths, px; the same as for the command.
FOCAL_PX = (50.0, 100_000.0)
#: The kinds of jobs that judge a film.
KINDS = ("verify", "identify")
VERIFY_FIELDS = ("claim", "badge", "focal_px", "require_original", "cover", "photographs")
#: The most photographs that may be asked for.
MOST_PHOTOGRAPHS = 1000
#: At most this many laws are given to a film's process: those of a claimed badge, or of the registry's layouts.
MOST_LAWS = 8
IDENTIFY_FIELDS = ("focal_px",)


async def start_job(request: Request, visitor: Visitor, *, kind: str | None = None, report: bool) -> Job:
    """Receive a film with its form, and let the job begin.

    Parameters: kind: verify or identify, None where the form's field `kind` says which; report: make the report too.
    Raises: Refusal where the form, the film or the claim cannot be used, or too many films wait.
    """
    studio = studio_of(request)
    with studio.jobs.receiving(kind or "verify", visitor.id) as job:
        fields = IDENTIFY_FIELDS if kind == "identify" else VERIFY_FIELDS if kind else ("kind", *VERIFY_FIELDS)
        form = await receive(request, job.folder, studio.settings.limits, fields=fields)
        # A field that was not filled in arrives as an empty text.
        given = {name: text.strip() for name, text in form.fields.items() if text.strip()}
        if form.video is None:
            raise Refusal(422, "fields", "The form has no film; send it as the file `video`.")
        job.kind = given.get("kind", job.kind)
        if job.kind not in KINDS:
            raise Refusal(422, "fields", "The field kind is verify or identify.")
        job.film_name, job.claim, job.film_sha256 = form.name, given.get("claim", ""), form.sha256
        if job.kind == "identify":
            job.label = "who it is"
            layouts = await run_in_threadpool(studio.registry.layouts)
            laws = await run_in_threadpool(_laws, layouts)
            job.standing, job.people = await run_in_threadpool(studio.standing), People(studio.registry)
            studio.jobs.submit(job, form.video, layouts=layouts, focal_px=_focal(given.get("focal_px")), laws=laws)
            return job
        await run_in_threadpool(submit_claim, studio, visitor, job, form.video, given, report=report)
    return job


def submit_claim(
    studio: Studio, visitor: Visitor, job: Job, video: Path, given: Mapping[str, str], *, report: bool
) -> None:
    """Let a job begin that judges a claim.

    Parameters: video: in the job's folder; given: the fields of the form that have a value; report: make it too.
    Raises: Refusal where the claim or a figure cannot be used.
    """
    found, laws = _claimed(studio, given, ids=visitor.may("issuer"))
    job.claimed_id, job.claim_source = found.badge.id, found.provenance.source
    vouched, job.standing = found.provenance.source == "registry", found.provenance.standing
    job.label, job.barred = Named(found.badge.name, found.badge.id, vouched).holder, found.barred
    studio.jobs.submit(
        job,
        video,
        found=found if visitor.may("issuer") else sealed(found),
        focal_px=_focal(given.get("focal_px")),
        require_original=_truth(given.get("require_original")),
        cover_share=_number(given, "cover", 0, 1, MIN_COVER_SHARE),
        photographs=int(_number(given, "photographs", 0, MOST_PHOTOGRAPHS, 0)),
        report=report,
        laws=laws,
    )


def sealed(found: Claimed) -> Claimed:
    """An enrolled badge for a film that somebody shows who may not issue: its report then tells no identity that the
    film itself does not show, neither as digits nor as lines in a plot.
    """
    if found.provenance.source != "registry" or found.badge.id is None:
        return found
    badge = replace(specimen_of(found.badge), name=found.badge.name)
    built = None if found.as_built is None else replace(found.as_built, badge_id="")
    return replace(found, badge=badge, as_built=built, seal=Seal.of(found.badge.id, secrets.token_bytes(16)))


def find_claimed(registry: Registry, claim: str, *, ids: bool) -> Claimed:
    """Like `claimed`; ids: whether those who ask may be told of other ids than the claimed one.

    Raises: Refusal 404 where the claim means nobody, 409 where it means several people.
    """
    try:
        found = claimed(registry, claim)
    except RegistryError as error:
        known = error.details.get("ids")
        if known == []:
            text = f"Nobody named {claim[:80]!r} is in the registry, and no badge has such an id."
            if alike := error.details.get("alike"):
                told = _names(alike, ids=ids)  # type: ignore[arg-type]
                text += f" The name looks like {' and '.join(told)}, but is written in other letters."
            raise Refusal(404, "no_claim", text) from error
        if known and not ids:
            text = (
                f"{len(known)} badges are meant by {claim[:80]!r}; claim the id that the person or an issuer gave you."  # type: ignore[arg-type]
            )
            raise Refusal(409, "ambiguous", text) from error
        if known:
            raise Refusal(409, "ambiguous", f"{str(error)[:1].upper()}{str(error)[1:]}.") from error
        raise
    alike = _names(found.provenance.alike, ids=ids)
    return replace(found, provenance=replace(found.provenance, alike=alike))


def _names(alike: Sequence[str], *, ids: bool) -> tuple[str, ...]:
    """People who look like somebody, each "NAME (ID)"; without the ids where these are not told."""
    return tuple(alike) if ids else tuple(one.rpartition(" (")[0] for one in alike)


def _laws(badges: Sequence[Badge]) -> list[Law]:
    """The laws of the registry's badges, traced here once, so that no film's process must trace them again."""
    pairs = {(badge.lens, grating.pitch_mm) for badge in badges for grating in badge.gratings}
    return [(lens, pitch_mm, view_law(lens, pitch_mm)) for lens, pitch_mm in list(pairs)[:MOST_LAWS]]


def _claimed(studio: Studio, given: Mapping[str, str], *, ids: bool) -> tuple[Claimed, list[Law]]:
    if ("claim" in given) == ("badge" in given):
        raise Refusal(
            422, "fields", "Say whose badge it is said to be: a name or an id as `claim`, or a badge.json as `badge`."
        )
    standing = studio.standing()
    if "claim" in given:
        found = find_claimed(studio.registry, given["claim"], ids=ids)
    else:
        found = claimed_by_file(studio.registry, badge_from_json(given["badge"]))
    alike = _names(found.provenance.alike, ids=ids) if "badge" in given else found.provenance.alike
    found = replace(found, provenance=replace(found.provenance, standing=standing, alike=alike))
    # The law of a visitor's own badge file is traced in the film's process, which has limits.
    return found, _laws([found.badge]) if found.provenance.source == "registry" else []


def _focal(text: str | None) -> float | None:
    return None if text is None else _number({"focal_px": text}, "focal_px", *FOCAL_PX, 0.0)


def _number(given: Mapping[str, str], name: str, least: float, most: float, otherwise: float) -> float:
    """A number of the form.  Raises: Refusal where it is none, or out of its range."""
    if name not in given:
        return otherwise
    try:
        value = float(given[name])
    except ValueError:
        value = math.nan
    if not least <= value <= most:
        raise Refusal(422, "fields", f"{name} is a number from {least:g} to {most:g}.")
    return value


def _truth(text: str | None) -> bool | None:
    if text is None:
        return None
    if text.lower() in ("false", "0", "off"):
        return False
    if text.lower() in ("true", "1", "on"):
        return True
    raise Refusal(422, "fields", "require_original is true or false.")
