"""Requests to web servers that no one vouches for: with a deadline for the whole, and an end to what is read."""

from __future__ import annotations

import http.client
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import IO, Any, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class WebAnswer:
    """What a web server answered: its status, and the first bytes of the content."""

    status: int
    content: bytes


class _Redirects(urllib.request.HTTPRedirectHandler):
    """Follows from web address to web address alone, and never with what was sent."""

    def redirect_request(
        self,
        req: urllib.request.Request,
        fp: IO[bytes],
        code: int,
        msg: str,
        headers: http.client.HTTPMessage,
        newurl: str,
    ) -> urllib.request.Request | None:
        if req.data is not None or not newurl.lower().startswith(("http://", "https://")):
            raise urllib.error.HTTPError(req.full_url, code, "it leads elsewhere", headers, fp)
        return super().redirect_request(req, fp, code, msg, headers, newurl)


_opener = urllib.request.build_opener(_Redirects)


def exchange(address: str, most_bytes: int, wait_s: float, content: bytes | None = None) -> WebAnswer:
    """Ask a web server, with POST if there is content to send.

    Parameters: wait_s: longest silence, seconds; `together` limits the whole.
    Raises: OSError, with a few words, if it is not reached, or breaks off.
    """
    headers = {"User-Agent": "moireid"} | ({} if content is None else {"Content-Type": "text/plain; charset=utf-8"})
    try:
        if not address.startswith(("http://", "https://")):
            raise OSError("it is no web address, which begins with http:// or https://")
        with _opener.open(urllib.request.Request(address, content, headers), timeout=wait_s) as answer:
            return WebAnswer(answer.status, _content(answer, most_bytes))
    except urllib.error.HTTPError as error:
        with error:
            return WebAnswer(error.code, _content(error, most_bytes))
    except (urllib.error.URLError, http.client.HTTPException, ValueError) as error:
        raise OSError(str(getattr(error, "reason", None) or error) or type(error).__name__) from error


def _content(answer: Any, most_bytes: int) -> bytes:
    """The first bytes of an answer.  Raises: OSError if it ends before the length that it states."""
    content = bytes(answer.read(most_bytes))
    if len(content) < most_bytes and answer.length:
        raise OSError("it broke off within its answer")
    return content


def together(calls: Mapping[str, Callable[[], T]], most_s: float) -> dict[str, T | Exception]:
    """Make calls at the same time; the result of each by its name, or the exception that it raised.

    One that has not ended after `most_s` seconds is given up: its result is a TimeoutError, and its thread is left.
    """
    results: dict[str, T | Exception] = {}

    def run(name: str, call: Callable[[], T]) -> None:
        try:
            results[name] = call()
        # Whatever one server makes of its answer, the others count.
        except Exception as error:  # noqa: BLE001
            results[name] = error

    threads = [threading.Thread(target=run, args=pair, daemon=True) for pair in calls.items()]
    until = time.monotonic() + most_s
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(max(0.0, until - time.monotonic()))
    late = TimeoutError(f"no answer after {most_s:g} s")
    return {name: results.get(name, late) for name in calls}
