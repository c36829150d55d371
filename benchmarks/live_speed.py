"""Speed and safety of the live check: run `.venv/bin/python benchmarks/live_speed.py [--seconds 20] [--clips 50]`.

1. Through `LiveCheck.push`: frames a second at 720p if they came as fast as they are taken, and processor time at 24 a
   second, faces and running verdicts with it.
2. Through the WebSocket of a studio on this machine, as JPEGs at 24 frames a second, as a browser sends them: how many
   were taken, how late answers came.
3. From the moment when the badge has moved enough to the running verdict that accepts it.
4. Replays of earlier true answers against fresh challenges, each started when it suits best; and the computed chance.

The person is simulated: a photograph of a face (scikit-image's) and a rendered badge that follows prompts.
"""

from __future__ import annotations

import asyncio
import json
import os
import socket
import statistics
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.verifier.session.claim import Claim
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script
from moireid_lab.bench.live import answer, frames, replays_passed
from moireid_studio.challenge.challenge import Prompt
from moireid_studio.challenge.chance import replay_chance
from moireid_studio.challenge.clock import MOVES, SLACK_S
from moireid_studio.challenge.session import LiveCheck

FPS = 24.0
#: Where the photograph's face is put, mm in the plane of the badge at rest, and px (as in tests/kit/portrait.py).
FACE_MM, FACE_PX, FACE_SIZE_PX = np.array([0.36, -138.3]), (640.0, 165.0), 190.0


def portrait() -> np.ndarray:
    """A photograph of a face as a webcam frames a person, (720, 1280) grey."""
    from skimage import data

    grey = cv2.cvtColor(data.astronaut(), cv2.COLOR_RGB2GRAY)
    scale = FACE_SIZE_PX / 87.0
    warp = np.array([[scale, 0, FACE_PX[0] - scale * 222.5], [0, scale, FACE_PX[1] - scale * 126.5]])
    return np.asarray(cv2.warpAffine(grey, warp, (1280, 720), borderMode=cv2.BORDER_REPLICATE), np.uint8)


def person(badge: Badge, seconds: float) -> list[np.ndarray]:
    """Pictures of a person who rests for three seconds and then moves the badge to and fro, and across the face."""
    ways = ("left", "right", "right", "left", "face", "right", "left", "left", "right", "farther", "nearer")
    moves = [Prompt(move, 3.0 + 1.5 * k) for k, move in enumerate(ways)]
    return list(frames(badge, portrait(), answer(moves, FACE_MM, reaction_s=0.0), length_s=seconds, fps=FPS))


def pushed(badge: Badge, pictures: list[np.ndarray]) -> dict[str, float | None]:
    """1 and 3: through `LiveCheck.push`, as fast as it goes."""
    with ThreadPoolExecutor(1) as aside:
        check, begun = LiveCheck(Claim(badge, badge.id), aside=aside), time.perf_counter()
        for k, picture in enumerate(pictures):
            check.push(picture, k / FPS, k / FPS)
        rate = len(pictures) / (time.perf_counter() - begun)
        check.finish()
    # As the frames come, each second has its verdict; here it is made in place.
    check, times, status = LiveCheck(Claim(badge, badge.id)), list[float](), list[dict]()
    for k, picture in enumerate(pictures):
        begun = time.process_time()
        status += [one for one in check.push(picture, k / FPS, k / FPS) if one["event"] == "status"]
        times.append(time.process_time() - begun)
    judging = [spent for spent in times if spent > 0.1]
    moved = next((one["time_s"] for one in status if one["reasons"][0]["level"] == "pass"), None)
    accepted = next((one["time_s"] for one in status if one["verdict"] == "accept"), None)
    return {
        "frames a second": rate,
        f"processor s a second, at {FPS:g} frames": sum(times) / len(pictures) * FPS,
        "a frame, ms, median": 1000 * statistics.median(times),
        "a running verdict, ms, median": 1000 * statistics.median(judging),
        "from enough motion to acceptance, s": None if None in (moved, accepted) else accepted - moved,
        "from any frame to its verdict, s, at most": 1.0 + max(judging),
    }


def through_socket(badge: Badge, pictures: list[np.ndarray]) -> dict[str, Any]:
    """2: through a studio's WebSocket at the camera's own pace."""
    import uvicorn

    from moireid.registry import open_registry
    from moireid_studio.app import create_app
    from moireid_studio.settings import Settings

    coded = [cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes() for picture in pictures]
    with tempfile.TemporaryDirectory() as folder:
        url = f"sqlite:///{Path(folder) / 'people.sqlite3'}"
        with open_registry(url, create=True) as registry:
            registry.enroll(badge)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        app = create_app(Settings(url, Path(folder) / "data", auth=False))
        server = uvicorn.Server(uvicorn.Config(app, port=port, log_level="warning"))
        thread = threading.Thread(target=server.run, daemon=True)
        thread.start()
        while not server.started:
            time.sleep(0.05)
        before = _cpu_s()
        found = asyncio.run(_sent(port, coded))
        server.should_exit = True
        thread.join(10)
        # The worker has gone by now, so its time is known; this process is server and sender in one.
        used = _cpu_s()
    size = statistics.mean(map(len, coded))
    return found | {
        "processor s, worker, start and verdict with it": used[1] - before[1],
        "processor s, server and sender": used[0] - before[0],
        "kB a picture": size / 1000,
        f"Mbit/s at {FPS:g} a second": FPS * size / 125e3,
    }


def _cpu_s() -> tuple[float, float]:
    """Processor seconds of this process and of the children that it had."""
    times = os.times()
    return times.user + times.system, times.children_user + times.children_system


async def _sent(port: int, coded: list[bytes], most_ahead: int = 5) -> dict[str, Any]:
    import websockets

    from moireid_studio.live.sockets import CLOCK

    async with websockets.connect(f"ws://127.0.0.1:{port}/live/socket") as connection:
        begun = time.perf_counter()
        await connection.send(json.dumps({"claim": "Ada Lovelace"}))
        while json.loads(await connection.recv())["event"] != "ready":
            pass
        ready_s = time.perf_counter() - begun
        sent_at: list[float] = []
        delays: list[float] = []
        status: list[dict] = []

        async def listen() -> dict:
            async for text in connection:
                event = json.loads(text)
                if event["event"] == "taken":
                    delays.append(time.perf_counter() - sent_at[event["frames"] - 1])
                elif event["event"] == "status":
                    status.append(event)
                elif event["event"] in ("verdict", "error"):
                    return event
            return {}

        listening = asyncio.create_task(listen())
        dropped, start = 0, time.perf_counter()
        for k, picture in enumerate(coded):
            await asyncio.sleep(max(start + k / FPS - time.perf_counter(), 0))
            if len(sent_at) - len(delays) >= most_ahead:
                dropped += 1
                continue
            sent_at.append(time.perf_counter())
            # As on the camera's page, each picture carries the time when it was taken, which is now.
            await connection.send(CLOCK.pack(1000 * sent_at[-1]) + picture)
        length = time.perf_counter() - start
        await connection.send(json.dumps({"do": "end"}))
        asked = time.perf_counter()
        last = await listening
    return {
        "ready after, s": ready_s,
        "pictures taken a second": (len(coded) - dropped) / length,
        "left out": dropped,
        "came late": status[-1]["late"] if status else 0,
        "answers after, ms, median": 1000 * statistics.median(delays),
        "answers after, ms, at most": 1000 * max(delays),
        "running verdicts": len(status),
        "verdict at the end": last.get("verdict"),
        "verdict after, s": time.perf_counter() - asked,
    }


def replayed(count: int) -> dict[str, Any]:
    """4: replays of earlier answers, and their computed chances."""
    own, other = replays_passed(count, seed=7, face_mm=FACE_MM)
    return {
        f"answers to {MOVES} moves": count,
        "that meet their own prompts": own,
        "that meet fresh ones": other,
        "computed chance of one replay": f"{replay_chance():.1e}",
        "of one with the most lies about time": f"{replay_chance(slack_s=SLACK_S):.1e}",
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a figure."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    wanted = wish.chosen(["push", "socket", "replays"])
    pictures = [] if wanted == ["replays"] else person(badge, wish.own.seconds)
    parts = {
        "push": lambda: pushed(badge, pictures),
        "socket": lambda: through_socket(badge, pictures),
        "replays": lambda: replayed(wish.clips or 50),
    }
    for part in wanted:
        yield from ({"part": part, "figure": name, "value": value} for name, value in parts[part]().items())


OPTIONS = {"--seconds": {"type": float, "default": 20.0, "help": "of film"}}
BENCH = Bench(rows, {"part": "<8", "figure": "<48", "value": ">12.5g"}, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
