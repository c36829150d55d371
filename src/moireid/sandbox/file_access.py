"""Which files a sealed process may open (those of its work, and the program's own), and its environment variables."""

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
#: Files for name resolution, and the trusted certificates; only for a process with the network.
NAMES = (
    "/etc/gai.conf",
    "/etc/host.conf",
    "/etc/hosts",
    "/etc/nsswitch.conf",
    "/etc/resolv.conf",
    "/etc/ssl/certs",
    "/run/systemd/resolve",
)
#: Where Matplotlib keeps what fonts there are: finding them takes longer than drawing.
FONTS = ("~/.cache/matplotlib", "~/.config/matplotlib")
#: Where the private files of this program are if they are not at their usual place.
PRIVATE_VARIABLES = ("MOIREID_KEYS", "MOIREID_SEEN")
#: A sealed process gets these variables of the environment and no other: any other may hold a password or a key.
KEPT_VARIABLES = ("PATH", "HOME", "LANG", "TZ", "TMPDIR", "LD_LIBRARY_PATH", "VIRTUAL_ENV", "MPLCONFIGDIR")
KEPT_BEGINNINGS = ("LC_", "PYTHON", "OPENCV_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_", "VECLIB_")


@dataclass(frozen=True)
class Reach:
    """What a sealed process may open, apart from the program's own files and its temporary folder.

    read: files and folders to read; write: those to read and to write; what is not there is left out.  keep_out:
    folders that stay closed even where they lie in what may be read.  imports: folders that its starter imports from.
    network: the TCP ports that it may connect to, as a library that opens a stream by itself must; it may use UDP, too.
    None: no network at all.
    """

    read: tuple[str, ...] = ()
    write: tuple[str, ...] = ()
    keep_out: tuple[str, ...] = ()
    imports: tuple[str, ...] = ()
    network: tuple[int, ...] | None = None


def reach(
    read: Iterable[Path | str] = (), write: Iterable[Path | str] = (), *, network: tuple[int, ...] | None = None
) -> Reach:
    """What one work may open; keys and what was seen of registries stay closed in any case.

    Parameters: network: as in `Reach`.
    Paths are resolved here, as the process may not follow a link that leads out of its reach.
    """
    from platformdirs import user_data_path

    places = [os.environ[name] for name in PRIVATE_VARIABLES if os.environ.get(name)]
    private = [user_data_path("moireid", appauthor=False), *(Path(place).expanduser() for place in places)]
    names = () if network is None else NAMES
    parts = [tuple(map(_real, paths)) for paths in ((*read, *names), write, private, _import_folders())]
    return Reach(parts[0], parts[1], parts[2], parts[3], network)


def program_folders(imports: Iterable[str]) -> list[str]:
    """The folders of the system, the interpreter and packages; not all of them need be there."""
    fonts = map(os.path.expanduser, FONTS)
    return list(dict.fromkeys((*SYSTEM, sys.prefix, sys.base_prefix, *imports, *fonts)))


def _import_folders() -> list[str]:
    """The folders that this program imports from, without the folder of its script, or the one that it was started in.

    Python puts that folder first (`sys.path[0]`).  It may hold anything: keys may be next to a script.  It is kept
    where it is a folder of packages, as in a program that was packed with all that it needs.
    """
    own = [os.path.dirname(os.path.dirname(_real(__file__)))]
    started = sys.path[:1] if not sys.flags.safe_path else []
    closed = {_real(one) for one in started if one and not _has_packages(one)}
    return own + [one for one in sys.path if one and _real(one) not in closed]


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


def kept_environment(environment: dict[str, str]) -> dict[str, str]:
    """The environment variables that a sealed process gets."""
    return {k: v for k, v in environment.items() if k in KEPT_VARIABLES or k.startswith(KEPT_BEGINNINGS)}


def _within(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder.rstrip("/") + "/")


def _real(path: Path | str) -> str:
    return os.path.realpath(path)
