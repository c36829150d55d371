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
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
from hostile_files import spoilt_from

from moireid.badge import load_badge
from moireid.registry import open_registry
from moireid_studio.auth.tokens import open_tokens

FILMS = Path(__file__).parents[1] / "tests" / "data" / "films"
#: Open files of the server, as most systems have it; askers of true uploads; bytes of a film that crawls.
FILES, ASKERS, CRAWLING_BYTES = 1024, 4, 1 << 20
#: Where silence comes from: another address of this machine than that of the true uploads.
FLOOD = ("127.0.0.9", 0) if sys.platform == "linux" else None


@contextmanager
def served(folder: Path) -> Iterator[tuple[int, list[str], Path]]:
    """A studio started by its command: its port, tokens of three verifiers, and its log."""
    os.environ["MOIREID_KEYS"] = str(folder / "keys")
    url, log = f"sqlite:///{folder}/registry.sqlite3", folder / "log"
    (folder / "films").mkdir()
    spoilt_from(folder / "films")
    with open_registry(url, create=True) as registry:
        registry.enroll(load_badge(folder / "films" / "badge.json"))
    with open_tokens(folder / "studio") as tokens:
        secrets = [tokens.create("verifier")[0] for _ in range(3)]
    code = "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"
    command = [sys.executable, "-c", code, "serve", "--port", "0", "--registry", url, "--data", str(folder / "studio")]
    few = ["sh", "-c", f'ulimit -Sn {FILES}; exec "$@"', "sh", *command]
    with log.open("wb") as stream, subprocess.Popen(few, stderr=stream) as server:
        while b"http://" not in (said := log.read_bytes()):
            time.sleep(0.1)
        try:
            yield int(said.split(b"http://127.0.0.1:")[1].split(b"/")[0]), secrets, log
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(60)


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
    """True uploads: status and seconds of each."""
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
                    if status != 200:
                        print(answer.text)
                except httpx.HTTPError as error:
                    status = 0
                    print(f"no answer: {type(error).__name__}")
                answers.append((status, time.monotonic() - begun))

        await asyncio.gather(*(asker() for _ in range(ASKERS)))
    return answers


async def flooded(port: int, tokens: list[str], films: Path, given: argparse.Namespace) -> None:
    """Ask while others hold up the studio, and print."""
    ended, held = Counter[str](), list[float]()
    film = (films / "long.mp4").read_bytes()
    quiet = await true(port, tokens[0], films, 4)
    others = [asyncio.create_task(silent(port, ended)) for _ in range(given.silent)]
    others += [asyncio.create_task(crawling(port, tokens[1 + k % 2], film, held)) for k in range(given.crawling)]
    await asyncio.sleep(given.before)
    answers = await true(port, tokens[0], films, given.true)
    await asyncio.sleep(given.after)
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
    alone, loaded = ([seconds for _, seconds in some] for some in (quiet, answers))
    print(f"true uploads: {dict(Counter(status for status, _ in answers))} (0: no answer)")
    print(
        f"median {statistics.median(loaded):.2f} s, longest {max(loaded):.2f} s; alone {statistics.median(alone):.2f} s"
    )
    print(f"silent connections: {dict(ended)}")
    print(f"uploads that crawled were ended {len(held)} times, after {max(held, default=0):.1f} s at most")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--silent", type=int, default=1100)
    parser.add_argument("--crawling", type=int, default=40)
    parser.add_argument("--true", type=int, default=20)
    parser.add_argument("--before", type=float, default=15.0, help="seconds of flood before the first true upload")
    parser.add_argument("--after", type=float, default=15.0, help="seconds of flood after the last one")
    given = parser.parse_args()
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 65536) if hard > 0 else 65536, hard))
    print(f"{os.cpu_count()} processors, load average {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as scratch, served(Path(scratch)) as (port, tokens, log):
        asyncio.run(flooded(port, tokens, Path(scratch) / "films", given))
        print(f"the server's log: {log.stat().st_size} bytes")


if __name__ == "__main__":
    main()
