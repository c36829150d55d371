"""A page of a web server that no one vouches for: with a deadline for the whole, and an end to what is read."""

from __future__ import annotations

import threading
import urllib.error
import urllib.request


def fetched(address: str, most_bytes: int, most_s: float) -> bytes:
    """The first bytes of what is at a web address.

    Parameters: most_s: longest wait for the whole, seconds; after it, the thread that waits is left.
    Raises: OSError, with a few words, if it is not reached, answers with another status than 200, or breaks off.
    """
    found: list[bytes | Exception] = []

    def run() -> None:
        try:
            found.append(_content(address, most_bytes, most_s))
        # Whatever a server makes of its answer, the caller is told of it.
        except Exception as error:  # noqa: BLE001
            found.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(most_s)
    if not found:
        raise TimeoutError(f"no answer after {most_s:g} s")
    if isinstance(found[0], Exception):
        raise OSError(str(found[0]) or type(found[0]).__name__) from found[0]
    return found[0]


def _content(address: str, most_bytes: int, wait_s: float) -> bytes:
    """The first bytes of an answer.  Raises: OSError if there is none, or it ends before the length that it states."""
    request = urllib.request.Request(address, headers={"User-Agent": "moireid"})
    try:
        with urllib.request.urlopen(request, timeout=wait_s) as answer:
            content = bytes(answer.read(most_bytes))
            if answer.status != 200:
                raise OSError(f"status {answer.status}")
            if len(content) < most_bytes and answer.length:
                raise OSError("it broke off within its answer")
            return content
    except urllib.error.HTTPError as error:
        with error:
            raise OSError(f"status {error.code}") from error
    except urllib.error.URLError as error:
        raise OSError(str(error.reason)) from error
