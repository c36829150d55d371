"""What a job's process says once a film has taken it over: sealed processes import it by name."""

from __future__ import annotations

import base64
import os
import struct
import time

from moireid.sandbox.child import Talk


def bad_progress(talk: Talk) -> None:
    _say(talk, {"progress": ["x", None]})


def bad_result(talk: Talk) -> None:
    _say(talk, {"result": {"verdict": ["x"], "input": 5}})


def bad_pictures(talk: Talk) -> None:
    _say(talk, {"pictures": {"files": {"a": 1}, "signals": 7}})


def says_stopped(talk: Talk) -> None:
    """End in the words of a studio that stops, which has its jobs done again."""
    _say(talk, {"ended": ["stopped", "The studio was stopped meanwhile.", True]})


def large(talk: Talk) -> None:
    talk.next()
    talk._pipe.send_bytes(b'{"x": [' + b"[]," * (4 << 20) + b"0]}")
    time.sleep(1000)


def partial(talk: Talk) -> None:
    talk.next()
    os.write(talk._pipe.fileno(), struct.pack("!i", 1 << 20) + b"{")
    time.sleep(1000)


def folder_for_film(talk: Talk) -> None:
    task = talk.next()
    film = task.folder / task.video
    film.unlink()
    (film / "deep").mkdir(parents=True)


def two_signatures(talk: Talk) -> None:
    """Ask for signatures under a claim of another film, and hide them in a file that is said to be sound."""
    asked = talk.next()
    claim = base64.b64encode(b"\x84\x6aSignature1 of any film").decode()
    got = []
    for _ in range(2):
        talk.send({"sign": claim})
        got.append(talk.next())
    asked.output.write_bytes(b"".join(got))


def forged_file(talk: Talk) -> None:
    """Ask for one signature, hide it in the file, and say that all is well."""
    asked = talk.next()
    talk.send({"sign": base64.b64encode(b"\x84\x6aSignature1 of any film").decode()})
    asked.output.write_bytes(talk.next())
    talk.send({"state": "Valid", "verdict": asked.report})


def no_text(talk: Talk) -> None:
    talk.next()
    talk.send({"sign": 5})


def _say(talk: Talk, what: dict[str, object]) -> None:
    talk.next()
    talk.send(what)
    time.sleep(1000)
