"""A simulated call: a person who hears prompts and follows them, and a line with delay, a codec and lost pictures.

Convention: one clock, s.  A prompt that is shown at the asker's is read aloud, travels, and is reacted to; a picture
travels back.  `Caller` is a course for `film.frames`, which asks it for places as time goes on.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.verifier.live.challenge import Prompt
from moireid_lab.bench.live.film import REST_MM, answer, course_place_mm

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
#: What a call gives a camera at 720p, bit/s; and how long somebody reads until the word that counts, and reacts, s.
BIT_RATE = 1_500_000
READS_S, REACTS_S = (0.8, 1.8), (0.3, 1.2)


class Caller:
    """A person in a call who holds a badge, and moves it as they are asked to."""

    def __init__(self, face_mm: Array, delay_s: float, chance: random.Random) -> None:
        """delay_s: of the call, there and back; face_mm: as `film.answer`."""
        self._face_mm, self._there_s, self._chance = face_mm, delay_s / 2, chance
        self._asked: list[Prompt] = []
        self._places, self._set_out_s = REST_MM[None], np.zeros(0)

    def hear(self, move: str, shown_s: float) -> None:
        """A prompt that the asker was shown at this time."""
        wait_s = self._chance.uniform(*READS_S) + self._there_s + self._chance.uniform(*REACTS_S)
        self._asked.append(Prompt(move, shown_s + wait_s))
        course = answer(self._asked, self._face_mm, reaction_s=0.0)
        self._places, self._set_out_s = course.places_mm, course.set_out_s

    def place_mm(self, time_s: float) -> Array:
        """Where the badge is."""
        return course_place_mm(self._places, self._set_out_s, time_s)


class Paused:
    """Somebody who plays a film of an earlier answer, and pauses it until the next prompt is heard.

    It is a course, too: that of the film, on the player's own clock.
    """

    def __init__(self, before: list[Prompt], face_mm: Array, delay_s: float, *, reaction_s: float = 0.5) -> None:
        self._course = answer(before, face_mm, reaction_s=reaction_s)
        self._ends_s = [*(prompt.at_s for prompt in before[1:]), before[-1].at_s + 30.0]
        self._there_s, self._told, self._begun_s = delay_s / 2, 0, 0.0
        self._from_s, self._until_s = before[0].at_s - 3.0, before[0].at_s

    def hear(self, move: str, shown_s: float) -> None:
        """A prompt: the film goes on with the next answer, whatever was asked."""
        if self._told == len(self._ends_s):
            return
        self._from_s, self._until_s = self._until_s, self._ends_s[self._told]
        self._begun_s, self._told = shown_s + READS_S[0] + self._there_s, self._told + 1

    def place_mm(self, time_s: float) -> Array:
        """Where the film shows the badge."""
        played_s = max(time_s - self._begun_s, 0.0)
        return self._course.place_mm(min(self._from_s + played_s, self._until_s))


def coded(pictures: Iterable[Luma], width: int, fps: float, *, loss: float, chance: random.Random) -> Iterator[Luma]:
    """What is seen of pictures in a tile of this width: coded as in a call; where one is lost, the last one stays."""
    encoder: Any = None
    shown: Luma | None = None
    for number, picture in enumerate(pictures):
        if encoder is None:
            encoder, decoder = _codec(picture.shape, fps), av.CodecContext.create("h264", "r")
        frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
        frame.pts, frame.time_base = number, Fraction(1, round(fps))
        came = [image for packet in encoder.encode(frame) for image in decoder.decode(packet)]
        if came and (shown is None or chance.random() >= loss):
            whole = came[-1].to_ndarray(format="gray")
            height = round(whole.shape[0] * width / whole.shape[1] / 2) * 2
            shown = np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
        if shown is not None:
            yield shown


def _codec(shape: tuple[int, ...], fps: float) -> Any:
    encoder: Any = av.CodecContext.create("libx264", "w")
    encoder.width, encoder.height, encoder.pix_fmt = shape[1], shape[0], "yuv420p"
    encoder.time_base, encoder.bit_rate = Fraction(1, round(fps)), BIT_RATE
    encoder.options = {"preset": "veryfast", "tune": "zerolatency"}
    return encoder
