"""Receipts of one-time links, and what they add to the report of the film that they are about."""

from __future__ import annotations

import json
from datetime import datetime
from typing import Any

from moireid.provenance import Standing
from moireid.registry import holder_of
from moireid.verifier.report.circumstances import Circumstances, read_id
from moireid.verifier.report.live_receipt import LiveReceipt, attached
from moireid_studio.challenge.live_headline import live_headline_of, shown
from moireid_studio.links import OneTimeLink
from moireid_studio.store.job import Job
from moireid_studio.studio import Studio


def name_of(studio: Studio, link: OneTimeLink) -> str:
    """Whose badge a link claims, as the registry knows now."""
    record = studio.registry.by_id(link.claim)
    return record.name if record is not None else "a person who is in the registry no longer"


def headline_for(studio: Studio, link: OneTimeLink) -> dict[str, str] | None:
    """The headline of a link's verdict, by the names that the registry knows now; None while it has none.

    Raises: RegistryError as `holder_of`.
    """
    if link.report is None or link.ended_at is None:
        return None
    event = json.loads(link.report)
    made = datetime.fromisoformat(link.ended_at)
    known = Circumstances(made, read=holder_of(studio.registry, read_id(event)), standing=studio.standing())
    return shown(live_headline_of(event, name_of(studio, link), known))


def receipt_for(studio: Studio, link: OneTimeLink) -> LiveReceipt:
    """The receipt of a link that has its verdict.  Raises: RegistryError as `headline_for`."""
    event = json.loads(link.report or "{}")
    return LiveReceipt(
        "one-time link",
        name_of(studio, link),
        link.ended_at or "",
        event["verdict"],
        link.report_sha256 or "",
        event["challenged"],
        link.claim if link.ids else None,
        title=(headline_for(studio, link) or {}).get("title"),
        film=link.film,
        registry=Standing(**event["registry"]) if event.get("registry") else None,
        asked_as=link.asks,
        link=link.id,
        made_at=link.made_at,
        opened_at=link.opened_at,
        used_at=link.used_at,
        pictures_kept=len(studio.links.pictures(link)),
        sealed=tuple(event["sealed"]) if "sealed" in event else None,
        decoder=event.get("input", {}).get("decoder"),
    )


def links_about(studio: Studio, job: Job) -> list[OneTimeLink]:
    """The links by which the owner of a film asked the person whom it is said to show about it, the oldest first."""
    if job.film_sha256 is None or job.claimed_id is None:
        return []
    return [link for link in studio.links.about(job.film_sha256, job.owner) if link.claim == job.claimed_id]


def with_live_checks(studio: Studio, job: Job) -> dict[str, Any]:
    """The report of a judged film with the receipts of the live checks about it."""
    done = [link for link in links_about(studio, job) if link.report is not None]
    return attached(job.result or {}, [receipt_for(studio, link) for link in done])
