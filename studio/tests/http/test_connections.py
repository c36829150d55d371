"""A server of silent and slow connections, with and without the proxy of `deploy/`.  Each test names the wrong
implementation it catches."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import socket
import subprocess
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import uvicorn

from moireid_studio.http.connections import ConnectionLimits, limited, neighbourhood

ASK = b"GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n"
POST = b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n"
#: Another address than those of the other clients, and of proxies.
FLOOD = ("127.0.0.9", 0)
OK, FULL = b"HTTP/1.1 200 OK", b"HTTP/1.1 503 Se"
CADDYFILE = Path(__file__).parents[3] / "deploy" / "Caddyfile"
Talk = Callable[[int], Awaitable[None]]


async def app(scope: Any, receive: Any, send: Any) -> None:
    """Answers once it has the whole body; to /refused at once."""
    while scope["path"] != "/refused" and (await receive()).get("more_body"):
        pass
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


@contextmanager
def served(limits: ConnectionLimits) -> Iterator[Callable[[Talk], None]]:
    """Runs a talk with a server of these limits, by its port."""

    async def go(talk: Talk) -> None:
        config = uvicorn.Config(app, port=0, http=limited(limits), lifespan="off", log_level="error")
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


async def asked(port: int, content: bytes = ASK) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        writer.write(content)
        return (await asyncio.wait_for(reader.read(), 5))[:15]
    finally:
        writer.close()


async def silent(
    port: int, count: int, host: str = FLOOD[0]
) -> list[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    return [await asyncio.open_connection("127.0.0.1", port, local_addr=(host, 0)) for _ in range(count)]


async def ends(reader: asyncio.StreamReader, seconds: float) -> bool:
    """Whether the server ends a connection within that time."""
    with contextlib.suppress(ConnectionError):
        try:
            await asyncio.wait_for(reader.read(), seconds)
        except TimeoutError:
            return False
    return True


def test_one_address_keeps_no_other_out() -> None:
    """Catches: a cap that turns away the next one, no matter who holds the places; a place that is never given back."""
    limits = ConnectionLimits(most=12, proxies=frozenset())

    async def talk(port: int) -> None:
        flood = await silent(port, 40)
        assert [await asked(port) for _ in range(5)] == [OK] * 5
        assert limits.held.total() <= 12 and limits.turned_away == 37
        for _, writer in flood:
            writer.close()
        await asyncio.sleep(0.1)
        assert limits.held.total() == 0

    with served(limits) as run:
        run(talk)


def test_all_connections_are_bounded() -> None:
    """Catches: sockets without a bound, until no file is left; a proxy that is taken for one visitor."""
    limits = ConnectionLimits(most=6, proxies=frozenset({FLOOD[0]}))

    async def talk(port: int) -> None:
        flood = await silent(port, 10)
        await asyncio.sleep(0.1)
        assert limits.held.total() == 6 and limits.turned_away == 0
        for _, writer in flood:
            writer.close()

    with served(limits) as run:
        run(talk)


def test_silent_connections_of_several_addresses_make_room() -> None:
    """Catches: four addresses that take a quarter each, say nothing, and keep everyone else out."""
    limits = ConnectionLimits(most=12, proxies=frozenset())

    async def talk(port: int) -> None:
        floods = [await silent(port, 3, f"127.0.0.{number}") for number in range(40, 44)]
        assert [await asked(port) for _ in range(5)] == [OK] * 5
        assert limits.turned_away == 0
        for _, writer in (one for flood in floods for one in flood):
            writer.close()

    with served(limits) as run:
        run(talk)


def test_proxies_are_known_by_their_network_too() -> None:
    """Catches: a proxy of a container's network, which the server trusts, bounded as one visitor."""
    limits = ConnectionLimits(most=12, proxies=frozenset({"10.0.0.0/8"}))
    assert all(limits.admit("10.1.2.3", total) for total in range(1, 13))
    assert [limits.admit("192.0.2.1", 1) for _ in range(4)] == [True, True, True, False]


def test_addresses_of_one_neighbour_count_together() -> None:
    """Catches: a bound by the address of IPv6, of which a visitor has as many as they like."""
    assert neighbourhood("2001:db8::1") == neighbourhood("2001:db8::ffff:1") != neighbourhood("2001:db8:0:1::1")
    assert neighbourhood("192.0.2.1") == "192.0.2.1" != neighbourhood("192.0.2.2")
    assert neighbourhood("::ffff:192.0.2.1") == "192.0.2.1"


def test_headers_that_crawl_get_no_more_time() -> None:
    """Catches: a time limit that each byte begins anew; one that ends a request at work."""
    limits = ConnectionLimits(most=10, headers_s=0.3)

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
        assert (await other.readline())[:15] == OK
        its.close()

    with served(limits) as run:
        run(talk)


def test_what_was_answered_must_end() -> None:
    """Catches: an upload that was refused, as it has no token, and goes on by a byte a second."""
    limits = ConnectionLimits(most=10, headers_s=0.3)

    async def talk(port: int) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(POST.replace(b"/ ", b"/refused "))
        assert (await reader.readline())[:15] == OK
        crawling = asyncio.create_task(crawl(writer))
        assert await ends(reader, 2.0)
        crawling.cancel()

    with served(limits) as run:
        run(talk)


async def crawl(writer: asyncio.StreamWriter) -> None:
    while True:
        writer.write(b"x")
        await asyncio.sleep(0.05)


@pytest.fixture
def caddyfile(tmp_path: Path) -> Path:
    """The proxy's own file, for one studio on this machine: addresses and times alone are others."""
    if shutil.which("caddy") is None:
        pytest.skip("caddy is not installed")
    text = CADDYFILE.read_text(encoding="utf-8")
    assert text.count("studio:8000") == text.count("read_header 10s") == 1
    text = text.replace("studio:8000", "127.0.0.1:{$UPSTREAM}")
    path = tmp_path / "Caddyfile"
    path.write_text(text.replace("read_header 10s", "read_header 1s").replace("{\n", "{\n\tadmin off\n", 1))
    return path


def test_the_proxy_s_file_is_one() -> None:
    """Catches: a directive that the proxy does not know, with which it does not start."""
    if shutil.which("caddy") is None:
        pytest.skip("caddy is not installed")
    command = ["caddy", "validate", "--adapter", "caddyfile", "--config", str(CADDYFILE)]
    given = os.environ | {"SITE": "verify.example.org"}
    done = subprocess.run(command, env=given, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_proxy_takes_silence_on_itself(caddyfile: Path, tmp_path: Path) -> None:
    """Catches: a proxy that hands each connection on, or keeps silent ones for ever."""
    limits = ConnectionLimits(most=3, proxies=frozenset({"127.0.0.1"}))
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        front = int(one.getsockname()[1])

    async def talk(port: int) -> None:
        places = {"SITE": f"http://127.0.0.1:{front}", "UPSTREAM": str(port), "HOME": str(tmp_path)}
        proxy = await asyncio.create_subprocess_exec(
            "caddy",
            "run",
            "--config",
            str(caddyfile),
            "--adapter",
            "caddyfile",
            env=os.environ | places,
            stderr=asyncio.subprocess.DEVNULL,
        )
        try:
            await until_open(front)
            flood = await silent(front, 60)
            assert [await asked(front, ASK.replace(b"x", f"127.0.0.1:{front}".encode())) for _ in range(5)] == [OK] * 5
            assert await ends(flood[0][0], 5.0) and limits.turned_away == 0
            for _, writer in flood:
                writer.close()
        finally:
            proxy.terminate()
            await proxy.wait()

    with served(limits) as run:
        run(talk)


async def until_open(port: int) -> None:
    for _ in range(200):
        with contextlib.suppress(OSError):
            _, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.close()
            return
        await asyncio.sleep(0.05)
    pytest.fail("the proxy does not start")
