"""Few stills of a badge, morphed by optical flow: run `moireid lab bench morphed`.

flow: two to six stills of a true film, evenly over 0.3 of parallax, morphed into each other by the camera's place
    (`true_films.morph`), over another film that goes sideways to and fro within these views, nearer and farther.
alone: the same, each cell of the code by itself.
minterpolate: stills of a true film in order of time, and FFmpeg's own interpolation between them.
true: a true film on the same trajectory, as it is and through a call.
outside: the same by a tracer that shares nothing with `moireid.simulate`, with motions of its own.

`cells` is how far a film's typical cell moves, over how far the rows make it.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Literal

import av
import numpy as np
import outside.build
import outside.camera
import outside.film
import outside.motion
import outside.page
from natural_films import prepared
from true_films.morph import Morph, stills
from true_films.paths import DEPTH, swaying

from moireid.badge import Badge, load_badge
from moireid.designer import Order, design_badge
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion
from moireid.simulate.recording.encode import RECIPES, FilmWriter, kept_frames
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.part import OWN, Asked, Part, Row, film_row

Kind = Literal["flow", "alone", "minterpolate", "true", "outside"]
FRAMES, FPS, CRF = 150, 30, 23
PHONE, SMALL = Camera(), Camera(1280, 720, 1150.0)
MOTIONS = ("walk", "measured", "sway")
#: Views that the stills are taken from, and that the film stays within: parallax sideways, and up and down.
HALF_VIEWS = np.array([[-0.15, -0.05], [0.15, 0.05]])


@dataclass(frozen=True)
class Case:
    """One kind of film.  stills: how many; recipe: through which service, as `moireid simulate --recipe`; pattern: of
    the code, None for the usual one.
    """

    kind: Kind
    stills: int = 0
    metres: float = 1.0
    format: str = "board"
    axes: str = "x"
    recipe: str | None = None
    pattern: str | None = None

    @property
    def name(self) -> str:
        """In a few words."""
        what = f"{self.stills} stills, {self.kind}" if self.stills else self.kind
        ways = "".join(f", {word}" for word in (self.recipe, self.pattern) if word)
        return f"{what}, {self.format} {self.axes}, {self.metres:g} m{ways}"


CALLS = ("call", "meeting", "chat")
PLACES = (("board", "x", 1.0), ("board", "x", 2.0), ("board", "xy", 1.0), ("a6", "x", 1.0))
CASES = (
    *(Case("flow", count, metres, *badge) for count in (2, 3, 4, 6) for *badge, metres in PLACES),
    *(Case("flow", 2, metres, recipe=recipe) for recipe in ("call", "meeting") for metres in (1.0, 2.0)),
    *(Case("flow", count, pattern="cells") for count in (2, 3)),
    *(Case("alone", 2, metres, *badge) for *badge, metres in PLACES),
    *(Case("true", 0, metres, *badge) for *badge, metres in PLACES),
    *(Case(kind, 0, metres, recipe=way) for kind in ("true", "outside") for way in CALLS for metres in (1.0, 2.0)),
    *(Case("outside", 0, metres) for metres in (1.0, 2.0)),
    *(Case("minterpolate", count) for count in (12, 16)),
)


def badge_of(case: Case, seed: int) -> Badge:
    """A badge of its own for each seed."""
    payload = np.random.default_rng([seed, 7]).bytes(8)
    return design_badge(Order("Bench", axes=case.axes, pattern=case.pattern, format=case.format), payload)


def interpolated(source: Path, stills: int, target: Path) -> None:
    """A film's stills, evenly in time, and between them what FFmpeg's `minterpolate` makes of them."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        own = given.streams.video[0]
        stream = made.add_stream("libx264", rate=FPS, options={"crf": str(CRF), "threads": "2"})
        stream.width, stream.height, stream.pix_fmt = own.width, own.height, "yuv420p"
        graph = av.filter.Graph()
        step = Fraction(FRAMES - 1, (stills - 1) * FPS)
        feed = graph.add_buffer(template=own, time_base=step)
        between, sink = graph.add("minterpolate", f"fps={FPS}:mi_mode=mci"), graph.add("buffersink")
        feed.link_to(between)
        between.link_to(sink)
        graph.configure()
        wanted = np.rint(np.linspace(0, FRAMES - 1, stills)).astype(int).tolist()
        kept = [frame for number, frame in enumerate(given.decode(own)) if number in wanted]
        count = 0
        for number, frame in enumerate([*kept, None]):
            if frame is not None:
                frame.pts, frame.time_base = number, step
            graph.push(frame)
            for done in _pulled(graph):
                done.pts, done.time_base = count, Fraction(1, FPS)
                made.mux(stream.encode(done))
                count += 1
        made.mux(stream.encode())


def _pulled(graph: av.filter.Graph) -> Iterator[av.VideoFrame]:
    """The frames that are ready."""
    try:
        while True:
            yield graph.vpull()
    except (av.error.BlockingIOError, av.error.EOFError):
        return


def by_outside_tracer(case: Case, seed: int, folder: Path) -> tuple[Badge, Path]:
    """A true film by the outside tracer, and its badge."""
    home, path = prepared(folder) / "badge", folder / "traced.mp4"
    rng = np.random.default_rng([seed, round(10 * case.metres)])
    camera, page = outside.camera.drawn(rng, outside.camera.PHONE), outside.page.load_page(home)
    way = outside.motion.course(MOTIONS[seed % len(MOTIONS)], 1000 * case.metres, FRAMES / FPS, rng)
    shoot = outside.film.Shoot(FRAMES, FPS, CRF, seed)
    outside.film.film(page, outside.build.built(page, rng), camera, way, path, shoot)
    badge = load_badge(home / "badge.json")
    return badge, path if case.recipe is None else through(path, case.recipe, seed, folder / "film.mp4")


def through(source: Path, recipe: str, seed: int, target: Path) -> Path:
    """A film as a service leaves it."""
    way = RECIPES[recipe]
    with av.open(str(source)) as given:
        pictures = [frame.to_ndarray(format="gray") for frame in given.decode(video=0)]
    with FilmWriter(target, target.name, pictures[0].shape[::-1], FPS, way) as writer:
        for number in kept_frames(way, len(pictures), seed).tolist():
            writer.write(pictures[number], number)
    return target


def made(case: Case, seed: int, folder: Path) -> tuple[Badge, Path]:
    """One film, and its badge."""
    if case.kind == "outside":
        return by_outside_tracer(case, seed, folder)
    badge = badge_of(case, seed)
    small = case.format == "board" and case.metres <= 1
    scene = Scene(badge, Build.typical(seed), SMALL if small else PHONE)
    motion: Motion = swaying(HALF_VIEWS, 1000 * case.metres, seed, depth=DEPTH)
    show = None
    if case.kind in ("flow", "alone"):
        views = np.linspace(*HALF_VIEWS, case.stills)
        taken = stills(scene, np.column_stack([views, np.full(case.stills, 1000 * case.metres)]), seed)
        show = Morph(taken, case.kind == "alone").shown
    path = folder / "film.mp4"
    crf = None if case.recipe else CRF
    film(scene, motion, path, frames=FRAMES, fps=FPS, show=show, seed=seed, crf=crf, recipe=case.recipe, overwrite=True)
    if case.kind != "minterpolate":
        return badge, path
    interpolated(path, case.stills, folder / "between.mp4")
    return badge, folder / "between.mp4"


def judged(job: tuple[Case, int], folder: Path) -> Row:
    """One film, made and judged."""
    case, seed = job
    with tempfile.TemporaryDirectory(dir=folder) as own:
        badge, path = made(case, seed, Path(own))
        report = verify(path, Question(badge, badge.id))
    words = [f"{case.stills} stills" if case.stills else "", case.kind, case.recipe or "", case.pattern or ""]
    motion = report.identity.cell_motion
    cells = {"cells": motion and motion.typical}
    return film_row(", ".join(filter(None, words)), report, true=case.stills == 0, **cells)


def cases(asked: Asked) -> dict[str, tuple[Case, int]]:
    """All films."""
    return {f"{case.name}|{seed}": (case, seed) for seed in range(1, 1 + (asked.clips or 1)) for case in CASES}


QUESTIONS = {
    "forged": "Is a film rejected of two to six stills, morphed by optical flow?",
    "genuine": "Is a true film on such trajectories accepted, also through a call, a meeting, a chat?",
}
PART = Part(QUESTIONS, f"{OWN}; outside: benchmarks/outside", cases, judged, 1)
