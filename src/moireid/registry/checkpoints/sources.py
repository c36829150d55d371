"""Checkpoints that others kept: in a file, in a folder of them, or at a web address."""

from __future__ import annotations

from pathlib import Path

from moireid.errors import RegistryError, SpecError
from moireid.files import open_regular
from moireid.registry.checkpoints.checkpoint import ORIGIN, Checkpoint, checkpoint_from
from moireid.registry.checkpoints.web import fetched

#: A checkpoint is 250 bytes, more with the lines of witnesses; and how long a web server may take.
LONGEST, WAIT_S = 65536, 15.0


def checkpoints_from(source: str) -> list[Checkpoint]:
    """The checkpoints that somebody else kept.

    Parameters
    ----------
    source : str
        Path of a checkpoint, or of a folder of them, or an address that begins with http:// or https://.

    Returns
    -------
    list of Checkpoint
        At least one; their signatures are not checked yet.

    Raises
    ------
    RegistryError
        If there is none, or it cannot be read.
    """
    if source.startswith(("http://", "https://")):
        return [checkpoint_from(_fetched(source), source)]
    path = Path(source)
    if not path.is_dir():
        return [checkpoint_from(_read(path), source)]
    texts = {one: _read(one) for one in sorted(path.iterdir()) if one.is_file()}
    found = [checkpoint_from(text, str(one)) for one, text in texts.items() if text.startswith(ORIGIN)]
    if not found:
        raise RegistryError(f"no file in folder {source} is a checkpoint; give one that holds some")
    return found


def one_checkpoint_from(source: str) -> Checkpoint:
    """The one checkpoint in a file or at a web address.

    Raises: RegistryError if there is none; SpecError if there are several.
    """
    found = checkpoints_from(source)
    if len(found) != 1:
        raise SpecError(f"{source} holds {len(found)} checkpoints; give the newest one of the registry")
    return found[0]


def _read(path: Path) -> str:
    try:
        with open_regular(path) as stream:
            return stream.read(LONGEST).decode("utf-8", errors="replace")
    except OSError as error:
        raise RegistryError(
            f"checkpoint {path} cannot be read ({error.strerror}); give the path of a file or folder, or a web address"
        ) from error


def _fetched(address: str) -> str:
    try:
        return fetched(address, LONGEST, WAIT_S).decode("utf-8", errors="replace")
    except OSError as error:
        raise RegistryError(f"checkpoint {address} cannot be fetched ({error}); check the address") from error
