"""Processor time of a verify over that of decoding: run `moireid lab bench verify --keep DIR`.

The films are those of `speed_films.py`; `--keep` keeps them.

Measured is a whole verify over decoding the whole film by two threads of FFmpeg, once the libraries are loaded: the
least of two runs, in CPU seconds of all threads.  Each film has a process of its own, with the
threads of a usual one.
"""

from __future__ import annotations

import re
import time
from pathlib import Path

import av
import cv2
from speed_films import SHORT, speed_films

from moireid.verifier import Question, verify
from moireid_lab.bench.part import OWN, RIGHT, WRONG, Asked, Part, Row

RUNS, THREADS = 2, 2
#: The most that a check should take, over decoding.
MOST = 1.8


def decode_cpu_s(film: Path) -> float:
    """CPU seconds of decoding and nothing else: no picture is turned into counts."""
    begun = time.process_time()
    with av.open(str(film)) as source:
        stream = source.streams.video[0]
        stream.thread_type, stream.codec_context.thread_count = "AUTO", THREADS
        for _ in source.decode(stream):
            pass
    return time.process_time() - begun


def judged(name: str, folder: Path) -> Row:
    """What a film costs."""
    # Children of the engine are limited to one thread; a user's process is not.
    cv2.setNumThreads(max(cv2.getNumberOfCPUs(), 2))
    one = next(film for film in speed_films() if film.name == name)
    own = folder / re.sub(r"\W+", "_", name)
    own.mkdir(exist_ok=True)
    film = one.within(own)
    claim = Question(one.badge, one.badge.id)
    verify(SHORT, claim)
    decode_s, verify_s = [], []
    for _ in range(RUNS):
        decode_s.append(decode_cpu_s(film))
        begun = time.process_time()
        report = verify(film, claim)
        verify_s.append(time.process_time() - begun)
    ratio, frames = min(verify_s) / min(decode_s), report.frames["read"]
    answer = RIGHT if ratio <= MOST else WRONG
    figures = {"over decoding": ratio, "ms a frame": 1e3 * min(verify_s) / frames}
    return {"kind": name, "answers": {"speed": answer}, "verdict": report.verdict} | figures


def cases(asked: Asked) -> dict[str, str]:
    """All films."""
    return {film.name: film.name for film in speed_films()}


QUESTIONS = {"speed": "Does a check take at most 1.8 times the processor time of decoding?"}
PART = Part(QUESTIONS, OWN, cases, judged)
