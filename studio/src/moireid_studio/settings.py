"""Where the studio's things are, whether it asks for tokens, and its limits."""

from __future__ import annotations

import socket
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.errors import SpecError
from moireid.question import CheckLevel
from moireid.user_settings import data_folder

if TYPE_CHECKING:
    from moireid.cli.witness_options import WitnessCheck


@dataclass(frozen=True)
class Limits:
    """What one visitor, and all of them together, may ask of the machine.

    upload_bytes: of one film; form_bytes: of all other fields of a form; picture_bytes, pictures_bytes: of one logo or
    portrait, and of all that come with one form; idle_s, upload_s: an upload is ended when it sends nothing for idle_s,
    or takes longer than upload_s; uploads: most films on their way; workers: films judged at a time, here or on a
    cluster; waiting: most jobs that wait, more are refused; job_s: wall time of one job;
    memory_bytes: private memory of one job; disk_bytes: of all films and results, half of it for one owner; keep_s: how
    long results are kept; stop_s: how long a job may go on once the studio stops, before it is given back; kept: how
    many results are kept for one owner; requests_a_minute, uploads_a_minute: of one token, issuers may upload twice as
    often.
    """

    upload_bytes: int = 512 << 20
    form_bytes: int = 1 << 20
    picture_bytes: int = 10_000_000
    pictures_bytes: int = 100_000_000
    idle_s: float = 30.0
    upload_s: float = 900.0
    uploads: int = 128
    workers: int = 2
    waiting: int = 32
    job_s: float = 600.0
    memory_bytes: int = 1 << 30
    disk_bytes: int = 20 << 30
    keep_s: float = 3600.0
    stop_s: float = 10.0
    kept: int = 500
    requests_a_minute: int = 3000
    uploads_a_minute: int = 600


@dataclass(frozen=True)
class Settings:
    """One studio: its registry (an SQLAlchemy URL, None for the default one), its folder, and its limits.

    auth: ask for tokens; without it anyone who reaches the server may do all, so it must listen on loopback alone;
    trust: fingerprint of the one authority that counts, None for the one that was seen at this registry first;
    state: the database of tokens and links, None for files in the folder; scheduler: of Dask, whose workers judge
    films, None for this machine; worker_url: by which they reach this studio; unsealed: whether films are also read
    where nothing seals their process; level: the least level that a film or a live check must reach to be accepted
    (`Question.level`), whatever a visitor asks for; public_url: the address by which other people reach the studio,
    with a slash at its end, None for the one by which each visitor has reached it; witness_check: the checkpoint that
    audits compare with, and the witnesses that must have signed it, None where none is asked.
    """

    registry_url: str | None = None
    data: Path = field(default_factory=lambda: default_data())
    auth: bool = True
    limits: Limits = field(default_factory=Limits)
    trust: str | None = None
    state: str | None = None
    scheduler: str | None = None
    worker_url: str = ""
    unsealed: bool = False
    level: CheckLevel | None = None
    public_url: str | None = None
    witness_check: WitnessCheck | None = None


def default_data() -> Path:
    """The studio's default folder; it is not created here.  Raises: SpecError for a user without a home folder."""
    if (folder := data_folder()) is None:
        raise SpecError("this user has no home folder for a studio; name a folder (data)")
    return folder / "studio"


def listening(host: str, port: int) -> socket.socket:
    """A socket that listens there.  Raises: SpecError where none can."""
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        both = host == "::" and socket.has_dualstack_ipv6()
        return socket.create_server((host, port), family=family, dualstack_ipv6=both)
    except OSError as error:
        raise SpecError(
            f"nothing can listen on port {port} of {host} ({error.strerror}); choose another --port, or --host"
        ) from error
