"""What all routes share: the settings, the open registry, the tokens, and the jobs."""

from __future__ import annotations

import fcntl
import threading
from contextlib import ExitStack

from starlette.requests import HTTPConnection

from moireid.errors import RegistryError, SpecError
from moireid.provenance import Standing
from moireid.registry import Audit, Registry, default_url, open_registry
from moireid.registry.signing.client import signer_address
from moireid.registry.url import read_url
from moireid.web.auth.tokens import Tokens
from moireid.web.jobs.queue import Jobs
from moireid.web.problems import Refusal
from moireid.web.settings import Settings


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
            self.jobs = Jobs(settings.data / "jobs", settings.limits)
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
