"""The fields of a form, including small files and pictures, and JSON, within the studio's limits; `uploads.py` takes
films.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass, field
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.routing import APIRoute
from starlette.datastructures import UploadFile
from starlette.types import Message

from moireid_studio.auth.guard import Visitor
from moireid_studio.pictures import KIND
from moireid_studio.problems import Refusal
from moireid_studio.store.stored_pictures import StoredPicture
from moireid_studio.studio import studio_of
from moireid_studio.uploads import called, in_time

#: More than any of our forms has; and files of other forms, such as a badge.json.
MOST_FIELDS, MOST_FILES = 40, 2
#: Forms with pictures that come at a time: small files among them are held in memory.
_large = threading.BoundedSemaphore(4)


@dataclass(frozen=True)
class Fields:
    """What was sent: texts by name, the bytes of files by name, and pictures by name, of which a field may have
    several; empty file fields are left out.
    """

    texts: dict[str, str]
    files: dict[str, bytes]
    pictures: dict[str, list[StoredPicture]] = field(default_factory=dict)


def within(request: Request, most: int | None = None, came: Callable[[int], None] = lambda _: None) -> Request:
    """The same request, of which no more is read than `most` bytes, or `Limits.form_bytes`: reading on raises
    HTTPException 413, and 408 where it stops or is very slow.

    Bytes are counted as they arrive, because a body sent in pieces need not state its length.

    Parameters
    ----------
    came
        Called with how many have come so far; it may refuse more.
    """
    limits, seen = studio_of(request).settings.limits, 0
    most = limits.form_bytes if most is None else most
    timed = in_time(request, limits)

    async def receive() -> Message:
        nonlocal seen
        try:
            message = await timed.receive()
        except TimeoutError as error:
            raise HTTPException(408, "The form stopped, or came too slowly; send it again.") from error
        seen += len(message.get("body", b""))
        if seen > most:
            raise too_large(most)
        came(seen)
        return message

    return Request(request.scope, receive)


class ShortRoute(APIRoute):
    """A route whose body is read `within` the limit, where the framework reads it."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """As the framework has it."""
        handler = super().get_route_handler()
        if self.body_field is None:
            return handler

        async def short(request: Request) -> Response:
            return await handler(within(request))

        return short


def too_large(most: int) -> HTTPException:
    """The refusal of a form."""
    size = f"{most // 1024} kB" if most < 10_000_000 else f"{most / 1e6:.0f} MB"
    return HTTPException(413, f"This form is larger than {size}; send less at a time.")


async def picture_fields(request: Request, visitor: Visitor, most: Mapping[str, int]) -> Fields:
    """The fields of a form that may have pictures; a large one takes one of the visitor's places for uploads.

    Parameters
    ----------
    most
        The fields with pictures, and how many each may have.

    Notes
    -----
    Raises: HTTPException where its pictures are larger than `Limits.pictures_bytes`, or all else than
    `Limits.form_bytes`; Refusal as `Jobs.admit` and `Jobs.stored`.
    """
    studio = studio_of(request)
    limits, length = studio.settings.limits, request.headers.get("content-length", "")
    small = length.isdecimal() and int(length) <= limits.form_bytes
    if small or not request.headers.get("content-type", "").startswith("multipart/form-data"):
        return await _read(request, within(request), most)
    if not _large.acquire(blocking=False):
        text = "Too many forms with pictures come at once; try again in a minute."
        raise Refusal(503, "busy", text, headers={"Retry-After": "60"})
    try:
        return await _read_large(request, visitor, most)
    finally:
        _large.release()


async def _read_large(request: Request, visitor: Visitor, most: Mapping[str, int]) -> Fields:
    studio = studio_of(request)
    limits = studio.settings.limits
    async with studio.jobs.coming(KIND, visitor.id, visitor.role) as job:
        body = within(request, limits.form_bytes + limits.pictures_bytes, lambda size: studio.jobs.stored(job, size))
        sent = await _read(request, body, most)
        await run_in_threadpool(studio.jobs.remove, job)
    return sent


async def _read(request: Request, body: Request, most: Mapping[str, int]) -> Fields:
    """The form of a body; `most` as for `picture_fields`.  Raises: HTTPException."""
    least = studio_of(request).settings.limits.form_bytes
    files: dict[str, bytes] = {}
    pictures: dict[str, list[StoredPicture]] = {}
    counts = {"max_files": MOST_FILES + sum(most.values()), "max_fields": MOST_FIELDS}
    async with body.form(**counts, max_part_size=least) as sent:
        texts = {key: value for key, value in sent.multi_items() if isinstance(value, str)}
        for key, value in sent.multi_items():
            if not isinstance(value, UploadFile) or not (data := await value.read()):
                continue
            if key not in most:
                files[key] = data
                continue
            pictures.setdefault(key, []).append(StoredPicture(called(value.filename or ""), data))
            if len(pictures[key]) > most[key]:
                raise HTTPException(413, f"Of the files {key} at most {most[key]} are taken; send less at a time.")
    if sum(map(len, files.values())) + sum(len(text.encode("utf-8", "replace")) for text in texts.values()) > least:
        raise too_large(least)
    return Fields(texts, files, pictures)
