"""The one rule by which a Dask scheduler is reached: who reaches one runs code on all its workers.

So its address is tls://, with certificates of both sides as Dask's own settings name them, or a loopback one.
"""

from __future__ import annotations

import ipaddress
from typing import Any
from urllib.parse import urlsplit

from moireid.errors import SpecError
from moireid.extras import missing_extra

CONNECT_S = 10.0


def is_loopback(host: str) -> bool:
    """Whether a host (a name or an address without a port) is this machine's loopback."""
    bare = host.strip("[]").lower()
    if bare == "localhost":
        return True
    try:
        return ipaddress.ip_address(bare).is_loopback
    except ValueError:
        return False


def scheduler_client(address: str, extra: tuple[str, str]) -> Any:
    """A client of the scheduler at an address.

    Parameters: extra: extra and distribution that install Dask.
    Raises: SpecError if the address is open to others, or no scheduler answers there; MissingExtraError.
    """
    try:
        import distributed
    except ImportError as error:
        raise missing_extra("a scheduler", error.name or "distributed", *extra) from error
    try:
        parts = urlsplit(address)
        if parts.scheme != "tls" and not is_loopback(parts.hostname or ""):
            raise SpecError(
                f"every program that reaches the scheduler at {address[:100]!r} runs code on its workers; give "
                "tls://HOST:PORT, with certificates in Dask's settings (distributed.comm.tls), or a loopback address"
            )
        # With an invalid address, a client would leave its thread in a state in which no other client can start.
        distributed.comm.get_address_host_port(address)
        return distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError, RuntimeError, NotImplementedError) as error:
        words = " ".join(str(error).split())[:150] or type(error).__name__
        raise SpecError(
            f"no Dask scheduler answers at {address[:100]!r} ({words}); give tls://HOST:PORT as `dask scheduler` "
            "prints it, or tcp://127.0.0.1:PORT of this machine"
        ) from error
