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
    """Base of every error that moireid raises on purpose.

    Parameters
    ----------
    message : str
        One sentence: what, what was got, what is allowed, what to do next.
    **details : object
        The figures of the message by name, units in the names.  They become the attribute `details`.

    Notes
    -----
    Convention: every other error of moireid is a direct subclass, so ``except MoireIdError`` catches them all.
    """

    def __init__(self, message: str, **details: object) -> None:
        super().__init__(message)
        self.details = details


class SpecError(MoireIdError):
    """A badge, profile or option says something impossible.

    Notes
    -----
    Parameters as `MoireIdError`.  Give another value, or another file.
    """


class DesignError(MoireIdError):
    """No badge can do what was asked.

    Notes
    -----
    Parameters as `MoireIdError`.  The message names the nearest wish that can be met, and `details` holds its figures.
    """


class FabricationError(MoireIdError):
    """A file for print or cutting could not be made, or failed the check after writing.

    Notes
    -----
    Parameters as `MoireIdError`.  No file of the set appears.
    """


class CodeError(MoireIdError):
    """A payload does not fit a code, or symbols are no code word.

    Notes
    -----
    Parameters as `MoireIdError`.
    """


class MediaError(MoireIdError):
    """A video, image or motion file cannot be read or written.

    Notes
    -----
    Parameters as `MoireIdError`.
    """


class RegistryError(MoireIdError):
    """The registry lacks, or already holds, what was asked for.

    Notes
    -----
    Parameters as `MoireIdError`.  It is also raised where the database fails, or where a record is not as it was
    signed.
    """


class MissingExtraError(MoireIdError):
    """An optional package is not installed.

    Notes
    -----
    Parameters as `MoireIdError`.  The message holds the command that installs it.
    """
