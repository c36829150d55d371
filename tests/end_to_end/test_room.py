"""The agent of examples/06_judge_a_room.py in a room of a real conferencing server, Janus."""

from __future__ import annotations

import http.server
import json
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import pytest

from kit.janus import ROOM, Participant, janus
from kit.places import ROOT
from kit.streams import write_stream
from moireid.badge import Badge
from moireid.registry import open_registry
from moireid.simulate import Build, Camera, Scene, film, motion_named

#: Half of what a call sends: the sender, the server and the judge share two processors here.
FPS = 15
#: Longest wait for a verdict, s.
WAIT_S = 90


class Posted(http.server.BaseHTTPRequestHandler):
    """What a platform is sent."""

    def do_POST(self) -> None:
        said = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.server.said.put(said)  # type: ignore[attr-defined]
        self.send_response(200)
        self.end_headers()

    def log_message(self, *words: object) -> None:
        pass


@pytest.fixture
def platform() -> Iterator[tuple[str, queue.SimpleQueue[dict[str, Any]]]]:
    """A platform's address for verdicts, and what was posted there."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Posted)
    server.said = queue.SimpleQueue()  # type: ignore[attr-defined]
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}/", server.said  # type: ignore[attr-defined]
    server.shutdown()
    server.server_close()


@pytest.fixture
def stream(ada: Badge, tmp_path: Path) -> Path:
    """A film of a true badge that moves."""
    scene = Scene(ada, Build.typical(seed=1), Camera(width=1280, height=720, focal_px=967.0))
    motion = motion_named("circle", distance_mm=800.0, seed=1)
    made = film(scene, motion, tmp_path / "film.mp4", frames=24 * FPS, fps=FPS)
    with av.open(str(made.video)) as opened:
        shots = [one.reformat(format="yuv420p") for one in opened.decode(video=0)]
    return write_stream(tmp_path / "film.ts", shots, fps=FPS)


@pytest.mark.slow
@pytest.mark.alone
def test_everybody_in_a_room_is_judged_by_name(
    ada: Badge, stream: Path, platform: tuple[str, queue.SimpleQueue[dict[str, Any]]], tmp_path: Path
) -> None:
    """Catches: an agent that judges the wrong video, holds it against nobody, or keeps the verdict to itself."""
    address, said = platform
    url = f"sqlite:///{tmp_path}/people.sqlite3"
    with open_registry(url, create=True) as registry:
        registry.enroll(ada)
    (tmp_path / "janus").mkdir()
    agent = [sys.executable, str(ROOT / "examples" / "06_judge_a_room.py")]
    with janus(tmp_path / "janus") as server:
        options = ["--registry", url, "--seconds", "45", "--post", address]
        with subprocess.Popen([*agent, server, str(ROOM), *options], stdout=subprocess.DEVNULL) as judging:
            try:
                assert first(server, said, "Ada Lovelace", stream, "verdict", "accept")["why"] == []
                refused = first(server, said, "Nobody Known", stream, "event", "error")
            finally:
                judging.kill()
    assert "Nobody Known" in refused["why"]


def first(
    server: str, said: queue.SimpleQueue[dict[str, Any]], name: str, stream: Path, key: str, wanted: str
) -> dict[str, Any]:
    """The first post that says this of a participant, who then leaves; it must come before the last verdict.

    A machine that is busy loses pictures: then the verdict on the last seconds takes longer.
    """
    someone = Participant(server, name, stream)
    try:
        while (document := said.get(timeout=WAIT_S))[key] != wanted:
            assert document["event"] not in ("verdict", "error") and document["verdict"] != "reject", document
            assert document["name"] == name
    finally:
        someone.end()
    return document
