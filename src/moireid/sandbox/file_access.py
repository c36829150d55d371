"""Which files a sealed process may open: those of its work, and the program's own."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

#: What every program reads: libraries, fonts, the time zone, and figures about the machine and about itself.  Not all
#: of /proc, as it shows the environment of other processes.
SYSTEM = (
    "/usr",
    "/lib",
    "/lib32",
    "/lib64",
    "/etc/fonts",
    "/etc/ld.so.cache",
    "/etc/localtime",
    "/proc/self",
    "/proc/cpuinfo",
    "/proc/meminfo",
    "/proc/stat",
    "/proc/sys/vm",
    "/sys/devices/system",
    "/dev/urandom",
    "/dev/zero",
)
NULL = "/dev/null"
#: Where Matplotlib keeps what fonts there are: finding them takes longer than drawing.
FONTS = ("~/.cache/matplotlib", "~/.config/matplotlib")
#: Where the private files of this program are if they are not at their usual place.
PRIVATE_VARIABLES = ("MOIREID_KEYS", "MOIREID_SEEN")


@dataclass(frozen=True)
class Reach:
    """What a sealed process may open, apart from the program's own files and its temporary folder.

    read: files and folders to read; write: those to read and to write; what is not there is left out.  keep_out:
    folders that stay closed even where they lie in what may be read.  imports: folders that its starter imports from.
    """

    read: tuple[str, ...] = ()
    write: tuple[str, ...] = ()
    keep_out: tuple[str, ...] = ()
    imports: tuple[str, ...] = ()


def reach(read: Iterable[Path | str] = (), write: Iterable[Path | str] = ()) -> Reach:
    """What one work may open; keys and what was seen of registries stay closed in any case.

    Paths are resolved here, as the process may not follow a link that leads out of its reach.
    """
    from moireid.user_settings import data_folder, expanded

    places = [os.environ[name] for name in PRIVATE_VARIABLES if os.environ.get(name)]
    private = [*filter(None, [data_folder()]), *map(expanded, places)]
    return Reach(*(tuple(map(_real, paths)) for paths in (read, write, private, _import_folders())))


def program_folders(imports: Iterable[str]) -> list[str]:
    """The folders of the system, the interpreter and packages; not all of them need be there."""
    fonts = map(os.path.expanduser, FONTS)
    return list(dict.fromkeys((*SYSTEM, sys.prefix, sys.base_prefix, *imports, *fonts)))


def _import_folders() -> list[str]:
    """The folder of this package, and those that this program imports from, without the folder of its script, or the
    one that it was started in.

    Python puts that folder first (`sys.path[0]`).  It may hold anything: keys may be next to a script.  It is kept
    where it is a folder of packages, as in a program that was packed with all that it needs.
    """
    started = sys.path[:1] if not sys.flags.safe_path else []
    closed = {_real(one) for one in started if one and not _has_packages(one)}
    imports = [one for one in sys.path if one and _real(one) not in closed]
    return [os.path.dirname(os.path.dirname(_real(__file__))), *imports]


def _has_packages(folder: str) -> bool:
    try:
        return os.path.isfile(folder) or any(name.endswith(".dist-info") for name in os.listdir(folder))
    except OSError:
        return False


def open_parts(root: str, closed: Iterable[str]) -> list[str]:
    """The parts of a folder or file that together are all of it except what is closed; Landlock knows no exceptions.

    Convention: a file that is made later in a folder that holds something closed is closed, too.
    """
    root = _real(root)
    closed = [one for one in closed if one == root or one.startswith(root.rstrip("/") + "/") or _within(root, one)]
    if not closed:
        return [root]
    if any(_within(root, one) for one in closed):
        return []
    try:
        children = sorted(entry.path for entry in os.scandir(root) if not entry.is_symlink())
    except OSError:
        return []
    return [part for child in children for part in open_parts(child, closed)]


def _within(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder.rstrip("/") + "/")


def _real(path: Path | str) -> str:
    return os.path.realpath(path)
