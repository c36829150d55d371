"""The fields of a form, including small files, and JSON, within the studio's limit; `uploads.py` takes films."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from fastapi import HTTPException, Request, Response
from fastapi.routing import APIRoute
from starlette.datastructures import UploadFile
from starlette.types import Message

from moireid.web.studio import studio_of

#: More than any of our forms has.
MOST_FIELDS = 40


@dataclass(frozen=True)
class Fields:
    """What was sent: texts by name, and the bytes of files by name; empty file fields are left out."""

    texts: dict[str, str]
    files: dict[str, bytes]


def within(request: Request) -> Request:
    """The same request, of which no more is read than `Limits.form_bytes`: reading on raises HTTPException 413, and 408
    where it stands still.

    Bytes are counted as they arrive, because a body sent in pieces need not state its length.
    """
    limits, seen = studio_of(request).settings.limits, 0
    most = limits.form_bytes

    async def receive() -> Message:
        nonlocal seen
        try:
            async with asyncio.timeout(limits.idle_s):
                message = await request.receive()
        except TimeoutError as error:
            raise HTTPException(408, "The form stood still; send it again.") from error
        seen += len(message.get("body", b""))
        if seen > most:
            raise HTTPException(413, f"This form is larger than {most // 1024} kB; send less at a time.")
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


async def form_fields(request: Request) -> Fields:
    """The fields of the request's form; of a name sent twice the last counts.

    Raises: HTTPException where it is larger than `Limits.form_bytes`, or no form.
    """
    most = studio_of(request).settings.limits.form_bytes
    async with within(request).form(max_files=2, max_fields=MOST_FIELDS, max_part_size=most) as sent:
        texts = {key: value for key, value in sent.multi_items() if isinstance(value, str)}
        files = {key: await value.read() for key, value in sent.multi_items() if isinstance(value, UploadFile)}
    return Fields(texts, {key: data for key, data in files.items() if data})
