"""Speed and safety of the live check: run `.venv/bin/python benchmarks/live_speed.py [--seconds 20] [--replays 50]`.

1. Through `LiveCheck.push`: frames a second at 720p if they came as fast as they are taken, and processor time at 24 a
   second, faces and running verdicts with it.
2. Through the WebSocket of a studio on this machine, as JPEGs at 24 frames a second, as a browser sends them: how many
   were taken, how late answers came.
3. From the moment when the badge has moved enough to the running verdict that accepts it.
4. Replays of earlier true answers against fresh challenges, each started when it suits best; and the computed chance.

The person is simulated: a photograph of a face (scikit-image's) and a rendered badge that follows prompts.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import platform
import socket
import statistics
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.verifier.session.claim import Claim
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


def pushed(badge: Badge, pictures: list[np.ndarray]) -> None:
    """1 and 3: through `LiveCheck.push`, as fast as it goes."""
    with ThreadPoolExecutor(1) as aside:
        check = LiveCheck(Claim(badge, badge.id), aside=aside)
        events, begun, cpu = [], time.perf_counter(), time.process_time()
        for k, picture in enumerate(pictures):
            events += check.push(picture, k / FPS, k / FPS)
        wall = time.perf_counter() - begun
        check.finish()
        cpu = time.process_time() - cpu
    rate = len(pictures) / wall
    print(f"push: {rate:.0f} frames a second, running verdicts meanwhile: {len(events)}")
    # As the frames come, each second has its verdict; here it is made in place.
    check, now, times = LiveCheck(Claim(badge, badge.id)), 0.0, []
    cpu, events = time.process_time(), []
    for k, picture in enumerate(pictures):
        now = k / FPS
        one = time.process_time()
        events += check.push(picture, now, now)
        times.append(time.process_time() - one)
    cpu = time.process_time() - cpu
    print(f"push, a verdict each second: {cpu / len(pictures) * FPS:.2f} processor seconds a second at {FPS:g} frames")
    judging = [t for t in times if t > 0.1]
    print(
        f"  a frame {1000 * statistics.median(times):.1f} ms in the middle, a running verdict "
        f"{1000 * statistics.median(judging):.0f} ms"
    )
    status = [event for event in events if event["event"] == "status"]
    moved = next((e["time_s"] for e in status if e["reasons"][0]["level"] == "pass"), None)
    accepted = next((e["time_s"] for e in status if e["verdict"] == "accept"), None)
    if moved is None or accepted is None:
        print("verdict: none; give more --seconds")
    else:
        print(
            f"verdict: accepted {accepted - moved:.1f} s after the first verdict that saw enough motion, and made "
            f"within {1.0 + max(judging):.1f} s of any frame"
        )


def through_socket(badge: Badge, pictures: list[np.ndarray]) -> None:
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
        asyncio.run(_sent(port, coded))
        server.should_exit = True
        thread.join(10)
        # The worker has gone by now, so its time is known; this process is server and sender in one.
        used = _cpu_s()
    print(
        f"  processor seconds: worker {used[1] - before[1]:.1f}, start and verdict with it; server and sender "
        f"{used[0] - before[0]:.1f}"
    )
    size = statistics.mean(map(len, coded))
    print(f"  {size / 1000:.0f} kB a picture, {FPS * size / 125e3:.0f} Mbit/s at {FPS:g} a second")


def _cpu_s() -> tuple[float, float]:
    """Processor seconds of this process and of the children that it had."""
    times = os.times()
    return times.user + times.system, times.children_user + times.children_system


async def _sent(port: int, coded: list[bytes], most_ahead: int = 5) -> None:
    import websockets

    from moireid_studio.live.sockets import CLOCK

    async with websockets.connect(f"ws://127.0.0.1:{port}/live/socket") as connection:
        begun = time.perf_counter()
        await connection.send(json.dumps({"claim": "Ada Lovelace"}))
        while json.loads(await connection.recv())["event"] != "ready":
            pass
        print(f"WebSocket: ready after {time.perf_counter() - begun:.1f} s")
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
    kept = len(coded) - dropped
    print(
        f"  {len(coded)} pictures in {length:.1f} s: {kept / length:.1f} a second taken, {dropped} left out, "
        f"{status[-1]['late'] if status else 0} came late; answers after {1000 * statistics.median(delays):.0f} ms, "
        f"{1000 * max(delays):.0f} ms at most"
    )
    print(
        f"  {len(status)} running verdicts, the last {status[-1]['verdict'] if status else 'none'}; "
        f"at the end {last.get('verdict')} after {time.perf_counter() - asked:.1f} s"
    )


def main() -> None:
    """Print all four."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="of film")
    parser.add_argument("--replays", type=int, default=50)
    parser.add_argument("--only", choices=["push", "socket", "replays"])
    given = parser.parse_args()
    print(f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, OpenCV {cv2.__version__}")
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    if given.only != "replays":
        pictures = person(badge, given.seconds)
    if given.only in (None, "push"):
        pushed(badge, pictures)
    if given.only in (None, "socket"):
        through_socket(badge, pictures)
    if given.only in (None, "replays"):
        own, other = replays_passed(given.replays, seed=7, face_mm=FACE_MM)
        print(
            f"replays of {given.replays} true answers to {MOVES} moves: {own} meet their own prompts, {other} fresh "
            f"ones; computed chance of one replay {replay_chance():.1e}, of one with the most lies about time "
            f"{replay_chance(slack_s=SLACK_S):.1e}"
        )


if __name__ == "__main__":
    main()
