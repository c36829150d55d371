"""What all routes share: the settings, the open registry, and the tokens."""

from __future__ import annotations

from typing import TYPE_CHECKING

from moireid.registry import Registry, open_registry
from moireid.web.settings import Settings
from moireid.web.tokens import Tokens

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection


class Studio:
    """One running studio; a route gets it by `studio_of(request)`."""

    def __init__(self, settings: Settings) -> None:
        """Raises: RegistryError where the registry is absent, or the studio's folder cannot be used."""
        self.settings = settings
        self.registry: Registry = open_registry(settings.registry_url, create=False)
        self.tokens = Tokens(settings.data)

    def close(self) -> None:
        """Close what is open."""
        self.tokens.close()
        self.registry.close()


def studio_of(connection: HTTPConnection) -> Studio:
    """The studio that a request or a WebSocket has reached."""
    studio: Studio = connection.app.state.studio
    return studio
