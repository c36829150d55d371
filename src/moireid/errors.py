"""The error tree.

    MoireIdError
    ├── SpecError            a badge, profile or option says something impossible
    ├── DesignError          no badge can do what was asked; the message says which could
    ├── FabricationError     a file for print or cutting failed its own check
    ├── CodeError            a payload or a code word is not one
    ├── MediaError           a video, image or motion file cannot be read or written
    ├── RegistryError        the registry lacks, or already holds, what was asked for
    └── MissingExtraError    an optional package is not installed

Each message is one sentence: what is wrong, the value given, the values allowed, the next step.  `error.details` has
the figures too, so that a program need not parse the text.
"""

from __future__ import annotations

__all__ = [
    "CodeError",
    "DesignError",
    "FabricationError",
    "MediaError",
    "MissingExtraError",
    "MoireIdError",
    "RegistryError",
    "SpecError",
]


class MoireIdError(Exception):
    """Base of every error that moireid raises on purpose; `details` holds the figures of the message."""

    def __init__(self, message: str, **details: object) -> None:
        super().__init__(message)
        self.details = details


class SpecError(MoireIdError):
    """A badge, profile or option says something impossible."""


class DesignError(MoireIdError):
    """No badge can do what was asked; the message names the nearest that can."""


class FabricationError(MoireIdError):
    """A file for print or cutting could not be made, or failed the check after writing."""


class CodeError(MoireIdError):
    """A payload does not fit a code, or symbols are no code word."""


class MediaError(MoireIdError):
    """A video, image or motion file cannot be read or written."""


class RegistryError(MoireIdError):
    """The registry lacks, or already holds, what was asked for."""


class MissingExtraError(MoireIdError):
    """An optional package is not installed."""
