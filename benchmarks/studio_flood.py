"""A studio under clients that block it: run `.venv/bin/python benchmarks/studio_flood.py [--silent 1100]`.

Starts the studio by its command, with 1,024 open files as most systems allow, and opens against it, at once,

- connections of one address that say nothing, and come again as soon as they are ended;
- uploads of films that come at 100 bytes a second, by the tokens of two verifiers;
- and true uploads of small films at the same time, by another verifier, one after the other by several askers.

Prints how the true ones were answered and how long they took, how long an upload that crawls held its place, and what
the server wrote to its log.
"""

from __future__ import annotations

import argparse
import asyncio
import resource
import statistics
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import httpx
from studio_server import StudioServer, served

from moireid.badge import load_badge
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

#: Open files of the server, as most systems have it; askers of true uploads; bytes of a film that crawls.
FILES, ASKERS, CRAWLING_BYTES = 1024, 4, 1 << 20
#: Where silence comes from: another address of this machine than that of the true uploads.
FLOOD = ("127.0.0.9", 0) if sys.platform == "linux" else None


async def silent(port: int, ended: Counter[str]) -> None:
    """Connections that say nothing, one after the other."""
    while True:
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port, local_addr=FLOOD)
        except OSError:
            ended["not connected"] += 1
            await asyncio.sleep(0.5)
            continue
        try:
            await reader.read()
        except OSError:
            pass
        finally:
            ended["ended"] += 1
            writer.close()
        await asyncio.sleep(0.2)


async def crawling(port: int, token: str, film: bytes, held: list[float]) -> None:
    """Uploads that crawl, one after the other; how long each held its place."""
    head = b'--b\r\nContent-Disposition: form-data; name="video"; filename="a.mp4"\r\n\r\n' + film[:1000]
    lines = (
        "POST /api/jobs HTTP/1.1",
        "Host: x",
        f"Authorization: Bearer {token}",
        "Content-Type: multipart/form-data; boundary=b",
        f"Content-Length: {CRAWLING_BYTES}",
    )
    while True:
        begun = time.monotonic()
        try:
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write("\r\n".join((*lines, "", "")).encode() + head)
            answer = asyncio.create_task(reader.readline())
            while not answer.done():
                writer.write(bytes(50))
                await asyncio.wait({answer}, timeout=0.5)
            if b" 408 " in answer.result():
                held.append(time.monotonic() - begun)
            writer.close()
        except OSError:
            pass
        await asyncio.sleep(0.5)


async def true(port: int, token: str, films: Path, count: int) -> list[tuple[int, float]]:
    """True uploads: status, 0 without an answer, and seconds of each."""
    film, name = (films / "long.mp4").read_bytes(), load_badge(films / "badge.json").name
    waiting, answers = list(range(count)), list[tuple[int, float]]()
    async with httpx.AsyncClient(headers={"Authorization": f"Bearer {token}"}, timeout=120) as client:

        async def asker() -> None:
            while waiting:
                waiting.pop()
                begun = time.monotonic()
                form = {"files": {"video": ("film.mp4", film)}, "data": {"claim": name}}
                try:
                    answer = await client.post(f"http://127.0.0.1:{port}/api/verify", **form)
                    status = answer.status_code
                except httpx.HTTPError:
                    status = 0
                answers.append((status, time.monotonic() - begun))

        await asyncio.gather(*(asker() for _ in range(ASKERS)))
    return answers


async def flooded(studio: StudioServer, given: argparse.Namespace) -> Row:
    """Ask while others hold up the studio."""
    ended, held, port = Counter[str](), list[float](), int(studio.home.rpartition(":")[2])
    film, token = (studio.films / "long.mp4").read_bytes(), studio.tokens
    quiet = await true(port, token[0], studio.films, 4)
    others = [asyncio.create_task(silent(port, ended)) for _ in range(given.silent)]
    others += [asyncio.create_task(crawling(port, token[1 + k % 2], film, held)) for k in range(given.crawling)]
    await asyncio.sleep(given.before)
    answers = await true(port, token[0], studio.films, given.true)
    await asyncio.sleep(given.after)
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
    alone, loaded = ([seconds for _, seconds in some] for some in (quiet, answers))
    return {
        "true uploads": dict(Counter(status for status, _ in answers)),
        "median s": statistics.median(loaded),
        "longest s": max(loaded),
        "alone s": statistics.median(alone),
        "silent connections": dict(ended),
        "crawling ended": len(held),
        "after s, at most": max(held, default=0.0),
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a figure."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 65536) if hard > 0 else 65536, hard))
    with tempfile.TemporaryDirectory() as scratch, served(Path(scratch), verifiers=3, open_files=FILES) as studio:
        found = asyncio.run(flooded(studio, wish.own)) | {"bytes of the server's log": studio.log.stat().st_size}
    yield from ({"figure": name, "value": str(value)} for name, value in found.items())


OPTIONS = {
    "--silent": {"type": int, "default": 1100},
    "--crawling": {"type": int, "default": 40},
    "--true": {"type": int, "default": 20},
    "--before": {"type": float, "default": 15.0, "help": "seconds of flood before the first true upload"},
    "--after": {"type": float, "default": 15.0, "help": "seconds of flood after the last one"},
}
BENCH = Bench(rows, {"figure": "<26", "value": "<1"}, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
