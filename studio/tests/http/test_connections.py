"""A server of silent and slow connections.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import uvicorn

from moireid_studio.http.connections import ConnectionGuard, behind

ASK = b"GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
POST = b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n"


async def app(scope: Any, receive: Any, send: Any) -> None:
    """Answers once it has the whole body."""
    while scope["type"] == "http" and (await receive()).get("more_body"):
        pass
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


@contextmanager
def served(door: ConnectionGuard) -> Iterator[Callable[[Callable[[int], Awaitable[None]]], None]]:
    """Runs a talk with a server of that door, by its port."""

    async def go(talk: Callable[[int], Awaitable[None]]) -> None:
        config = uvicorn.Config(app, port=0, http=behind(door), lifespan="off", log_level="error")
        server = uvicorn.Server(config)
        serving = asyncio.create_task(server.serve())
        while not server.started:
            await asyncio.sleep(0.01)
        try:
            await talk(server.servers[0].sockets[0].getsockname()[1])
        finally:
            server.should_exit = True
            await serving

    yield lambda talk: asyncio.run(go(talk))


async def asked(port: int) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(ASK)
    try:
        return await asyncio.wait_for(reader.read(), 5)
    finally:
        writer.close()


def test_silent_connections_make_room_for_those_that_speak() -> None:
    """Catches: a cap that turns away the next one, whatever holds the places."""
    door = ConnectionGuard(most=10)

    async def talk(port: int) -> None:
        silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(40)]
        assert [(await asked(port))[:15] for _ in range(5)] == [b"HTTP/1.1 200 OK"] * 5
        assert len(door.silent) <= 10 and door.turned_away >= 30
        for _, writer in silent:
            writer.close()

    with served(door) as run:
        run(talk)


def test_slow_requests_make_room_too(monkeypatch: Any) -> None:
    """Catches: a body of a byte a second, by which a client without a token holds a place."""
    monkeypatch.setattr("moireid_studio.http.connections.YOUNG_S", 0.05)
    door = ConnectionGuard(most=5)

    async def talk(port: int) -> None:
        slow = [await asyncio.open_connection("127.0.0.1", port) for _ in range(5)]
        for _, writer in slow:
            writer.write(POST)
        await asyncio.sleep(0.2)
        assert len(door.coming) == 5
        assert (await asked(port))[:15] == b"HTTP/1.1 200 OK"
        for _, writer in slow:
            writer.close()

    with served(door) as run:
        run(talk)


def test_headers_that_crawl_get_no_more_time() -> None:
    """Catches: a time limit that each byte begins anew; one that ends a request at work."""
    door = ConnectionGuard(most=10, headers_s=0.3)

    async def talk(port: int) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        for byte in ASK[:-4]:
            writer.write(bytes([byte]))
            await asyncio.sleep(0.02)
            if reader.at_eof() or writer.is_closing():
                break
        else:
            pytest.fail(f"after {0.02 * len(ASK):g} s it still listens")
        other, its = await asyncio.open_connection("127.0.0.1", port)
        its.write(POST)
        await asyncio.sleep(0.5)
        its.write(bytes(1000))
        assert (await other.readline())[:15] == b"HTTP/1.1 200 OK"
        its.close()

    with served(door) as run:
        run(talk)
