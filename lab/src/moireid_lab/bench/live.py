"""Simulated challenges before a webcam and in a call, and replays of earlier answers to new prompts.

1. A person before a webcam: a true badge that follows prompts, in front of a picture of a face (`answer`, `frames`).
2. A call: a person who follows prompts (`Caller`), and a line with delay, a codec and lost pictures (`coded`).
3. Replays: an old true clip, started at the moment that fits best (`replays_passed`), or paused (`PausingPlayer`).

Convention: camera frame in mm, x right in the picture, y down, z forward; the camera stays still.  One clock, s.  In a
    call a prompt that the asker sees is read aloud, travels, and is reacted to; a picture travels back.
Source: the analytic renderer; the trajectory from place to place is that of least jerk, which hands approximate (Flash
    and Hogan 1985).
"""

from __future__ import annotations

import functools
import math
import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Camera, Instant, Scene
from moireid_studio.challenge.challenge import (
    AMOUNT_RATIO,
    FACE,
    SIDEWAYS_MM,
    UPRIGHT_MM,
    WAYS,
    Prompt,
    PromptPath,
    draw_prompts,
    judge_challenge,
)

Array = NDArray[np.float64]
#: A laptop's camera, and where the badge is held before it.
WEBCAM = Camera(width=1280, height=720, focal_px=900.0, noise_counts=2.0)
REST_MM = np.array([0.0, 70.0, 640.0])
#: How far a hand goes when it is asked to, sideways, upright and in depth, mm, and how long it takes.
GOES_MM, TAKES_S = (180.0, 80.0, 120.0), 0.9
#: How far a hand turns the badge as it carries it sideways and upright, rad/mm: 7 degrees for 20 cm.
TURNS = math.radians(7.0) / 200.0
#: Tremor: place, mm, and angle, rad, and rates, Hz.
TREMOR_MM, TREMOR_RAD, TREMOR_HZ = 1.5, math.radians(0.7), (0.4, 0.9, 1.7)


#: A photograph that is free of rights (it comes with scikit-image).
#: The face in the photograph, as dlib finds it, and where it is put in a picture of 1280 x 720: centre and size, px.
IN_PHOTOGRAPH = (222.5, 126.5, 87.0)
AT_PX, SIZE_PX = (640.0, 165.0), 190.0
#: That place in the plane of a badge at rest, mm: 640 mm away, 900 px.
FACE_MM = (np.array(AT_PX) - (639.5, 359.5)) / 900.0 * 640.0


@functools.cache
def portrait() -> NDArray[np.uint8]:
    """The photograph as a webcam frames a person, (720, 1280) grey."""
    from skimage import data

    grey = cv2.cvtColor(data.astronaut(), cv2.COLOR_RGB2GRAY)
    x, y, size = IN_PHOTOGRAPH
    scale = SIZE_PX / size
    warp = np.array([[scale, 0, AT_PX[0] - scale * x], [0, scale, AT_PX[1] - scale * y]])
    picture = cv2.warpAffine(grey, warp, (1280, 720), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picture, np.uint8)


@dataclass(frozen=True)
class Answer:
    """Places (K + 1, 3) mm of the badge, and when it sets out for each but the first (K,), s."""

    places_mm: Array
    set_out_s: Array

    def place_mm(self, time_s: float) -> Array:
        """Where the badge is."""
        return course_place_mm(self.places_mm, self.set_out_s, time_s)


def course_place_mm(places_mm: Array, set_out_s: Array, time_s: float) -> Array:
    """Where a badge is that sets out for each place but the first; parameters as the fields of `Answer`."""
    way = np.clip((time_s - set_out_s) / TAKES_S, 0, 1)
    share = way**3 * (10 - 15 * way + 6 * way**2)
    return np.asarray(places_mm[0] + share @ np.diff(places_mm, axis=0))


def answer(prompts: Sequence[Prompt], face_mm: Array, *, reaction_s: float = 0.5) -> Answer:
    """The course of a person who follows prompts.  face_mm (2,): place of the face in the badge's plane at rest."""
    places = [REST_MM]
    for prompt in prompts:
        place = places[-1].copy()
        if prompt.move == FACE:
            place[:2] = face_mm * place[2] / REST_MM[2]
        else:
            axis, sign = WAYS[prompt.move]
            # The person's left is the picture's right; up and nearer are less of y and z.
            place[axis] += sign * GOES_MM[axis] * (1 if axis == 0 else -1)
        places.append(place)
    return Answer(np.array(places), np.array([prompt.at_s for prompt in prompts]) + reaction_s)


def frames(
    badge: Badge,
    behind: NDArray[np.uint8],
    course: Answer | Caller | PausingPlayer,
    *,
    length_s: float,
    fps: float = 24.0,
    seed: int = 0,
    frozen: bool = False,
    build: Build | None = None,
    drawn: Callable[[Array], NDArray[np.float32]] | None = None,
) -> Iterator[NDArray[np.uint8]]:
    """Grey pictures of the badge before `behind` (height, width), one at a time.

    Parameters: frozen: a forged badge, whose fringes do not move; build: None for a typical one of this seed; drawn:
        what a program draws in place of the board, as light, of the camera's place in the badge's frame, mm.
    """
    scene = Scene(badge, build or Build.typical(seed), WEBCAM)
    renderer, rng = AnalyticRenderer(scene), np.random.default_rng(seed)
    noise = rng.standard_normal((WEBCAM.height + 64, WEBCAM.width + 64)).astype(np.float32) * WEBCAM.noise_counts
    phases = rng.uniform(0, 2 * math.pi, (6, len(TREMOR_HZ)))
    shown = None
    for number in range(round(length_s * fps)):
        time_s = number / fps
        tremor = np.sin(2 * math.pi * np.array(TREMOR_HZ) * time_s + phases).mean(axis=1)
        place = course.place_mm(time_s) + TREMOR_MM * tremor[3:]
        carried = place - REST_MM
        turn = Rotation.from_rotvec(TREMOR_RAD * tremor[:3] + TURNS * np.array([-carried[1], carried[0], 0.0]))
        camera = turn.inv().apply(-place)
        shown = camera if shown is None or not frozen else shown
        poses = Poses(camera[None], turn.as_matrix()[None])
        board = renderer.render(Instant(poses, poses, shown, picture=drawn(camera) if drawn else None))
        picture = behind.astype(np.float32)
        if board is not None:
            rows = slice(board.top, board.top + board.radiance.shape[0])
            columns = slice(board.left, board.left + board.radiance.shape[1])
            # A camera codes light by about its square root.
            light = board.coverage * board.radiance + (1 - board.coverage) * (picture[rows, columns] / 255) ** 2
            picture[rows, columns] = 255 * np.sqrt(np.clip(light, 0, 1))
            picture[rows, columns] = cv2.GaussianBlur(picture[rows, columns], (0, 0), 0.6)
        y, x = rng.integers(0, 64, 2)
        picture += noise[y : y + WEBCAM.height, x : x + WEBCAM.width]
        yield np.clip(np.rint(picture), 0, 255).astype(np.uint8)


Luma = NDArray[np.uint8]
#: What a call gives a camera at 720p, bit/s.  How long the asker reads until the word that counts, and how long the
#: person takes to react, s.
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


class PausingPlayer:
    """An attacker who plays a film of an earlier answer, and pauses it until the next prompt comes.

    Its places are those of the film, on the player's own clock.
    """

    def __init__(self, before: list[Prompt], face_mm: Array, delay_s: float, *, reaction_s: float = 0.5) -> None:
        self._course = answer(before, face_mm, reaction_s=reaction_s)
        self._ends_s = [*(prompt.at_s for prompt in before[1:]), before[-1].at_s + 30.0]
        self._there_s, self._played, self._begun_s = delay_s / 2, 0, 0.0
        self._from_s, self._until_s = before[0].at_s - 3.0, before[0].at_s

    def hear(self, move: str, shown_s: float) -> None:
        """A prompt: the film goes on with the next answer, to any prompt."""
        if self._played == len(self._ends_s):
            return
        self._from_s, self._until_s = self._until_s, self._ends_s[self._played]
        self._begun_s, self._played = shown_s + READS_S[0] + self._there_s, self._played + 1

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


#: Steps in which the replayer's clip is moved to suit the prompts, s.
SHIFT_S = 0.25


def course_of(
    course: Answer, prompts: Sequence[Prompt], *, length_s: float, fps: float = 24.0, seed: int = 0
) -> PromptPath:
    """What a check sees of an answer, without the pictures: places with a tremor, and when the face is covered."""
    times = np.arange(round(length_s * fps)) / fps
    place = np.array([course.place_mm(float(time_s)) for time_s in times])
    place[:, :2] += np.random.default_rng(seed).normal(0, 1.0, (len(times), 2))
    before_face = np.zeros(len(times), bool)
    for k, prompt in enumerate(prompts):
        if prompt.move == FACE:
            left = course.set_out_s[k + 1] if k + 1 < len(prompts) else np.inf
            before_face |= (times >= course.set_out_s[k] + 0.6) & (times <= left + 0.3)
    amounts = [place[:, 0] / SIDEWAYS_MM, -place[:, 1] / UPRIGHT_MM, -np.log(place[:, 2]) / math.log(AMOUNT_RATIO)]
    return PromptPath(times, np.column_stack(amounts), before_face)


def passes(course: PromptPath, prompts: Sequence[Prompt]) -> bool:
    """Whether a course meets a challenge."""
    return all(reason.level == "pass" for reason in judge_challenge(course, prompts))


def passes_in_order(course: PromptPath, prompts: Sequence[Prompt], shift_s: float) -> int:
    """How many prompts a course meets before the first that it does not, begun `shift_s` later."""
    later = PromptPath(course.times_s + shift_s, course.place, course.before_face)
    levels = [reason.level == "pass" for reason in judge_challenge(later, prompts)]
    return (*levels, False).index(False)


def passes_at_best(course: PromptPath, before: Sequence[Prompt], fresh: Sequence[Prompt]) -> bool:
    """Whether an earlier answer to `before` meets fresh prompts, whenever it is started."""
    apart = [new.at_s - old.at_s for new, old in zip(fresh, before, strict=True)]
    shifts = np.arange(min(apart) - 2.0, max(apart) + 2.0, SHIFT_S)
    return any(passes(PromptPath(course.times_s + s, course.place, course.before_face), fresh) for s in shifts)


def replays_passed(count: int, seed: int, face_mm: Array) -> tuple[int, int]:
    """Of `count` true answers, how many meet their own challenge, and how many another one, replayed.

    Parameters: face_mm: as `film.answer`.
    """
    chance = random.Random(seed)
    own = other = 0
    for number in range(count):
        before, fresh = draw_prompts(3.0, chance), draw_prompts(3.0, chance)
        followed = answer(before, face_mm, reaction_s=chance.uniform(0.3, 1.2))
        course = course_of(followed, before, length_s=before[-1].at_s + 6.0, seed=number)
        own += passes(course, before)
        other += passes_at_best(course, before, fresh)
    return own, other
