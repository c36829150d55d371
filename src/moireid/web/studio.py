"""What all routes share: the settings, the open registry, the tokens, and the jobs."""

from __future__ import annotations

import fcntl
import logging
import threading
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

from starlette.requests import HTTPConnection

from moireid import __version__
from moireid.errors import RegistryError, SpecError
from moireid.provenance import Standing
from moireid.registry import Audit, Registry, default_url, open_registry
from moireid.registry.signing.client import signer_address
from moireid.registry.url import read_url
from moireid.verifier.session.claim import with_badge_notes
from moireid.web.auth.tokens import Tokens
from moireid.web.jobs.queue import Job, Jobs
from moireid.web.links import Links
from moireid.web.problems import Refusal
from moireid.web.settings import Settings
from moireid.web.verdicts import Verdicts, said


class Studio:
    """One running studio; a route gets it by `studio_of(request)`."""

    def __init__(self, settings: Settings) -> None:
        """The default registry is made where it is absent; one that is named must be there.

        Raises: RegistryError where the registry is absent, was put back or is another authority's, or the studio's
            folder cannot be used; SpecError where another studio uses that folder.
        """
        self.settings, self._auditing = settings, threading.Lock()
        with ExitStack() as undo:
            self.registry: Registry = undo.enter_context(
                open_registry(settings.registry_url, create=settings.registry_url is None)
            )
            self.registry.standing(settings.trust)
            self.tokens = Tokens(settings.data)
            undo.callback(self.tokens.close)
            self._alone(undo)
            self.verdicts = Verdicts(settings.data, settings.keep_verdicts_days)
            undo.callback(self.verdicts.close)
            self.links = Links(settings.data)
            undo.callback(self.links.close)
            self.jobs = Jobs(settings.data / "jobs", settings.limits, self._judged)
            self._open = undo.pop_all()

    @property
    def for_children(self) -> dict[str, str | None]:
        """The registry's URL, and its keys or their signer, for processes that issue badges.

        These work in another folder, and may be older than all that.
        """
        url = read_url(self.settings.registry_url or default_url()).render_as_string(hide_password=False)
        keys = str(self.registry.key_path.parent.absolute())
        return {"registry_url": url, "keys": keys, "signer": signer_address()}

    def standing(self) -> Standing:
        """The registry's authority and head now.  Raises: Refusal 503 where it was put back while the studio runs."""
        try:
            return self.registry.standing(self.settings.trust)
        except RegistryError as error:
            text = self.sentence(error)
            raise Refusal(503, "registry", f"{text[:1].upper()}{text[1:]}.") from error

    def sentence(self, error: Exception | str) -> str:
        """An error's sentence without the registry's place, which is not for those who come from outside."""
        shown = self.registry.shown_url
        return " ".join(str(error).split()).replace(f"registry {shown}", "the registry").replace(shown, "the registry")

    def audit(self, expected_head: str) -> Audit:
        """Audit the registry; only one audit runs at a time, because each reads everything.

        Raises: RegistryError where `expected_head` is not a head; Refusal 503 where another audit runs.
        """
        if not self._auditing.acquire(blocking=False):
            raise Refusal(503, "busy", "Another audit runs; try again when it is done.", headers={"Retry-After": "30"})
        try:
            return self.registry.audit(expected_head.strip() or None)
        finally:
            self._auditing.release()

    def note_verdict(self, asked_by: str, kind: str, result: Mapping[str, Any], **about: Any) -> None:
        """Write down a verdict that is given; about: film_sha256, claim, claim_source and the standing that was asked.

        A verdict that cannot be written down is given all the same; the log of the server says so.
        """
        standing: Standing | None = about.pop("standing")
        asked = None if standing is None else f"{standing.fingerprint} {standing.head}"
        try:
            given = about | said(result) | {"registry": asked, "moireid": __version__}
            self.verdicts.note(token=asked_by, kind=kind, **given)
        except RegistryError as error:
            logging.getLogger(__name__).error("%s", error)

    def _judged(self, job: Job) -> None:
        """Write down what a film's job found; and add who else could have the badge that was identified."""
        if job.kind not in ("verify", "identify") or not isinstance(job.result, dict):
            return
        if job.kind == "identify":
            job.result = self._with_notes(job.result)
        about = {"film_sha256": job.film_sha256, "claim": job.claimed_id, "claim_source": job.claim_source}
        self.note_verdict(job.owner, job.kind, job.result, **about, standing=job.standing)

    def _with_notes(self, result: dict[str, Any]) -> dict[str, Any]:
        """An identification with what is to be said of the badge that was found, of which the decoder knows nothing."""
        found = result.get("found_id")
        if not isinstance(found, str) or not isinstance(result.get("reasons"), list):
            return result
        try:
            record = self.registry.by_id(found)
        except RegistryError as error:
            logging.getLogger(__name__).error("%s", error)
            return result
        if record is None:
            return result
        return with_badge_notes(result, record.badge, measured=record.as_built is not None)

    def close(self) -> None:
        """Close what is open."""
        self._open.close()

    def _alone(self, undo: ExitStack) -> None:
        """Hold the folder's lock, which the system releases however this process ends.

        Without the lock, another studio would remove the films here as leftovers of its own.
        """
        lock = undo.enter_context((self.settings.data / "lock").open("a"))
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise SpecError(
                f"another studio runs with the folder {self.settings.data}; stop it, or give another with --data"
            ) from error


def studio_of(connection: HTTPConnection) -> Studio:
    """The studio that a request or a WebSocket has reached."""
    studio: Studio = connection.app.state.studio
    return studio
