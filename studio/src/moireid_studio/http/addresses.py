"""The studio's address in links that other people open.

A browser states in the header Host by which name it reached the studio, and a program may state any.  What Host says is
in the answer to that one request alone: it is never kept, and no other visitor is shown it.  Where the operator has
given the address (`serve --public-url`), Host is not used.
"""

from __future__ import annotations

from dataclasses import dataclass

from fastapi import Request

from moireid.errors import SpecError
from moireid.scheduler import is_loopback
from moireid_studio.auth.guard import address_parts
from moireid_studio.studio import studio_of


@dataclass(frozen=True)
class StudioAddress:
    """An address of the studio, which ends with a slash; here_only: only programs of this machine reach it."""

    url: str
    here_only: bool


def address_for(request: Request) -> StudioAddress:
    """The address that the operator gave, or else the one by which this visitor reached the studio.

    Convention: where Host is no name and no address, the address on which the server listens takes its place.
    """
    url = studio_of(request).settings.public_url or str(request.base_url)
    return StudioAddress(url, is_loopback(address_parts(url).hostname or ""))


def checked_address(text: str) -> str:
    """An address of a studio as the operator gives it, with a slash at its end.

    Raises: SpecError where it is none, or where browsers would give no camera to its pages.
    """
    parts = address_parts(text.strip())
    try:
        port_is_valid = parts.port is None or parts.port > 0
    except ValueError:
        port_is_valid = False
    whole = parts.hostname and port_is_valid and parts.path in ("", "/")
    if not whole or parts.scheme not in ("https", "http") or "@" in parts.netloc or parts.query or parts.fragment:
        raise SpecError(f"{text[:200]!r} is no address of a studio; give one such as https://studio.example.org")
    if parts.scheme == "http" and not is_loopback(parts.hostname or ""):
        raise SpecError(
            f"{text[:200]!r} is not over https, and browsers give a camera to pages over https alone; let a proxy with "
            "a certificate pass requests on, and give its address"
        )
    return f"{parts.scheme}://{parts.netloc}/"
