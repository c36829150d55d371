"""Streams judged as they come, in the sealed process.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import hashlib
import json
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import pytest
from jsonschema import Draft202012Validator

from kit.streams import pictures, watched, write_stream
from moireid.json_schema import report_schema
from moireid.provenance import Revocation
from moireid.sandbox.seal import MEANS
from moireid_studio.watch.order import Patience


@pytest.fixture(scope="module")
def shots() -> list[av.VideoFrame]:
    return pictures()


@pytest.fixture(scope="module")
def film(shots: list[av.VideoFrame], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four seconds of a genuine board, as a transport stream."""
    return write_stream(tmp_path_factory.mktemp("film") / "film.ts", shots)


@pytest.fixture
def pipe(tmp_path: Path) -> Iterator[Path]:
    """A named pipe; what is written to it is written by a thread."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    yield path


def poured(content: bytes, pipe: Path, *, hold: threading.Event | None = None, seconds: float = 0.0) -> None:
    """Write into a pipe, over some seconds; with `hold` it stays open until that is set."""

    def pour() -> None:
        try:
            with pipe.open("wb", buffering=0) as stream:
                for k in range(0, len(content), 1 << 16):
                    stream.write(content[k : k + (1 << 16)])
                    time.sleep(seconds * (1 << 16) / len(content))
                if hold is not None:
                    hold.wait(30)
        except BrokenPipeError:
            pass

    threading.Thread(target=pour, daemon=True).start()


def codes(event: dict[str, Any], level: str) -> set[str]:
    return {one["code"] for one in event["reasons"] if one["level"] == level}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["mpegts", "matroska"])
def test_a_pipe_is_judged_as_a_film_and_reported_as_one(
    kind: str, shots: list[av.VideoFrame], pipe: Path, tmp_path: Path
) -> None:
    """Catches: a verdict without keys of `verify --json`; pictures that a pipe loses; a judge that is not sealed; a
    container that FFmpeg writes into a pipe and that is not read from one."""
    events: list[dict[str, Any]] = []
    content = write_stream(tmp_path / "film", shots, kind=kind).read_bytes()
    poured(content, pipe)
    found = watched(str(pipe), notify=events.append)
    assert found["verdict"] == "accept" and found["frames"] == {"read": 120, "tracked": 120}
    assert found["input"]["sha256"] == hashlib.sha256(content).hexdigest()
    assert found["end"] == {"why": "source", "text": ""} and found["cover"]["share"] > 0.9
    assert abs(found["input"]["fps"] - 30) < 0.5
    assert found["sealed"] == list(MEANS)
    assert found["input"]["decoder"].startswith("FFmpeg ")
    assert events[0] == {"event": "begun", "width": 1280, "height": 720}
    Draft202012Validator(json.loads(report_schema())).validate(found)


@pytest.mark.slow
def test_a_file_is_followed_while_it_grows(film: Path, tmp_path: Path) -> None:
    """Catches: an end at the present size; a wait without end; a file that is read before it is written."""
    growing, content = tmp_path / "growing.ts", film.read_bytes()
    growing.write_bytes(content[: len(content) // 4])

    def grow() -> None:
        with growing.open("ab") as stream:
            for k in range(1, 4):
                time.sleep(0.4)
                stream.write(content[k * len(content) // 4 : (k + 1) * len(content) // 4])
                stream.flush()

    threading.Thread(target=grow, daemon=True).start()
    begun = time.monotonic()
    # A film judged in time would need less than that to grow.
    found = watched(str(growing))
    assert time.monotonic() - begun > 2.0
    assert found["verdict"] == "accept" and found["frames"]["read"] == 120
    assert found["input"]["sha256"] == hashlib.sha256(content).hexdigest()


@pytest.mark.slow
def test_a_lie_is_rejected_and_a_revoked_badge_too(film: Path, pipe: Path, tmp_path: Path) -> None:
    """Catches: a judge that accepts whatever moves; a running verdict that accepts a badge which does not count."""
    forged = write_stream(tmp_path / "forged.ts", pictures("forged_reversed_1.0m"))
    assert watched(str(forged))["verdict"] == "reject"
    events: list[dict[str, Any]] = []
    poured(film.read_bytes(), pipe)
    barred = Revocation("lost", "The badge was revoked: lost.")
    found = watched(str(pipe), notify=events.append, barred=barred)
    assert found["verdict"] == "reject" and codes(found, "fail") == {"revoked"}
    assert {one["verdict"] for one in events if one["event"] == "status"} <= {"reject"}


@pytest.mark.slow
@pytest.mark.alone
def test_somebody_may_stop_it_and_its_time_may_end(film: Path, pipe: Path) -> None:
    """Catches: a stop that loses the verdict, a time that is not kept."""
    stop, hold = threading.Event(), threading.Event()

    def heed(event: dict[str, Any]) -> None:
        if event["event"] == "status" and event["verdict"] == "accept":
            stop.set()

    content = film.read_bytes()
    poured(content, pipe, hold=hold, seconds=4.0)
    found = watched(str(pipe), notify=heed, stop=stop, patience=Patience(8.0, 20.0, 1.0))
    hold.set()
    assert found["end"]["why"] == "asked" and found["verdict"] == "accept"
    hold, another = threading.Event(), pipe.with_name("another")
    os.mkfifo(another)
    poured(content, another, hold=hold)
    assert watched(str(another), seconds=1.0, patience=Patience(8.0, 20.0, 1.0))["end"]["why"] == "asked"
    hold.set()
