"""Where the studio's things lie, whether it asks for tokens, and its limits."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass, field
from pathlib import Path

from platformdirs import user_data_path


@dataclass(frozen=True)
class Limits:
    """What one visitor, and all of them together, may ask of the machine.

    upload_bytes: of one film; form_bytes: of all other fields of a form; idle_s: an upload that sends nothing for so
    long is given up; upload_s: and one that takes so long; workers: films judged at a time; waiting: jobs beyond those,
    before new ones are refused; job_s: wall time of one job; memory_bytes: private memory that it may ask for;
    keep_s: results are kept so long; kept: and so many of one owner.
    """

    upload_bytes: int = 512 << 20
    form_bytes: int = 1 << 20
    idle_s: float = 30.0
    upload_s: float = 900.0
    workers: int = 2
    waiting: int = 32
    job_s: float = 600.0
    memory_bytes: int = 1 << 30
    keep_s: float = 3600.0
    kept: int = 500


@dataclass(frozen=True)
class Settings:
    """One studio: its registry (an SQLAlchemy URL, None for the default one), its folder, and its limits.

    auth: ask for tokens; without it whoever reaches the server may do everything, so it must listen on loopback alone.
    """

    registry_url: str | None = None
    data: Path = field(default_factory=lambda: default_data())
    auth: bool = True
    limits: Limits = field(default_factory=Limits)


def default_data() -> Path:
    """The studio's folder unless told otherwise; nothing is made."""
    return user_data_path("moireid", appauthor=False) / "studio"


def is_loopback(host: str) -> bool:
    """Whether a host, a name or an address without a port, is this machine to itself."""
    bare = host.strip("[]").lower()
    if bare == "localhost":
        return True
    try:
        return ipaddress.ip_address(bare).is_loopback
    except ValueError:
        return False
