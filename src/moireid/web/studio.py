"""What all routes share: the settings, the open registry, the tokens, and the jobs."""

from __future__ import annotations

import fcntl
from contextlib import ExitStack
from typing import TYPE_CHECKING

from moireid.errors import SpecError
from moireid.registry import Registry, default_url, open_registry
from moireid.registry.url import read_url
from moireid.web.auth.tokens import Tokens
from moireid.web.jobs.queue import Jobs
from moireid.web.settings import Settings

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection


class Studio:
    """One running studio; a route gets it by `studio_of(request)`."""

    def __init__(self, settings: Settings) -> None:
        """Raises: RegistryError where the registry is absent, or the studio's folder cannot be used; SpecError where
        another studio uses that folder."""
        self.settings = settings
        with ExitStack() as undo:
            self.registry: Registry = undo.enter_context(open_registry(settings.registry_url, create=False))
            self.tokens = Tokens(settings.data)
            undo.callback(self.tokens.close)
            self._alone(undo)
            self.jobs = Jobs(settings.data / "jobs", settings.limits)
            self._open = undo.pop_all()

    @property
    def for_children(self) -> dict[str, str]:
        """Where a process that works in another folder, and may be older than the keys' place, finds the registry."""
        url = read_url(self.settings.registry_url or default_url()).render_as_string(hide_password=False)
        return {"registry_url": url, "keys": str(self.registry.key_path.parent.absolute())}

    def close(self) -> None:
        """Close what is open."""
        self._open.close()

    def _alone(self, undo: ExitStack) -> None:
        """Hold the folder's lock, which the system lets go of however this process ends.

        Another studio would take the films that lie here for leavings of its own.
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
