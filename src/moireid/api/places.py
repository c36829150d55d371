"""A registry by path or URL, and how it is opened for one call."""

from __future__ import annotations

import warnings
from contextlib import AbstractContextManager, nullcontext

from moireid import registry as room
from moireid.files import AnyPath, as_path
from moireid.provenance import Standing
from moireid.user_settings import expanded

#: An open registry, the path of an SQLite file, or an SQLAlchemy URL; None for the one in the user's data folder.
Place = room.Registry | AnyPath | None


class Registry(room.Registry):
    """An open registry of badges; a context manager that closes its connections.

    Parameters
    ----------
    place : str or Path, optional
        The path of an SQLite file, or an SQLAlchemy URL; None for the registry in the user's data folder.
    create : bool
        Make the registry, with its authority's key pair, if it is absent; if false, nothing is ever made.
    actor : str, optional
        The person or account that uses it, as the log names them; None for the account that runs this process.

    Raises
    ------
    RegistryError
        As `moireid.registry.open_registry`.
    """

    def __init__(self, place: AnyPath | None = None, *, create: bool = False, actor: str | None = None) -> None:
        opened = room.open_registry(url_of(place), create=create, actor=actor)
        super().__init__(opened._ledger, opened.actor)

    def __repr__(self) -> str:
        return f"Registry({self.shown_url!r}, authority {self.fingerprint})"


def url_of(place: AnyPath | None) -> str | None:
    """A registry that is given as URL or path, as text in which a path is no URL; None for the default one."""
    if place is None or (isinstance(place, str) and "://" in place):
        return place
    return str(expanded(str(as_path(place))).absolute())


def opened(place: Place) -> AbstractContextManager[room.Registry]:
    """The registry, open; one that was open already stays so."""
    if isinstance(place, room.Registry):
        return nullcontext(place)
    return room.open_registry(url_of(place), create=False)


def warn_of(standing: Standing) -> None:
    """Warn of what a user should know about the registry or bundle that was asked."""
    for note in standing.notes:
        warnings.warn(note, stacklevel=5)
