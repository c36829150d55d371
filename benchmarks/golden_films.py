"""The films of `golden.py`, made by a fixed version of the project: run by `golden.py --make`, never by hand.

Everything here is imported from a checkout of that version, so no later change of simulator, outside tracer, printing
or scripts moves a film.  Films have 120 frames of 720p at 30 frames a second; next to each, `NAME.mp4`, is the badge
that it claims, `NAME.json`.
"""

from __future__ import annotations

import csv
import re
import shutil
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import any_lens
import natural_films
import numpy as np
import outside_films
from outside.build import built
from outside.camera import drawn
from outside.film import Shoot
from outside.film import film as traced
from outside.flaws import Flaws, flawed
from outside.motion import course
from outside.page import load_page

from moireid.badge import load_badge
from moireid.designer import Order, design_badge, payload_from_hex
from moireid.errors import SpecError
from moireid.simulate.cameras import camera_named
from moireid.simulate.effects.table import KINDS as EFFECTS
from moireid.simulate.effects.table import effect_named
from moireid.simulate.filming import film as simulated
from moireid.simulate.forgeries.trajectories import KINDS as FORGERIES
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene

FRAMES, FPS, SIZE = 120, 30, (1280, 720)
#: In a smaller picture, what was filmed from 1 m is filmed from here.
NEARER = SIZE[0] / 1920
#: Of the forged films: motion, distance in metres and seed; and more of those that headlines once misled about.
FORGED = (("sway", 0.6, 0), ("linear", 1.0, 0), ("handheld", 0.6, 1), ("sway", 1.0, 1))
MORE_FORGED = ("true_sway_0.6_0", "true_linear_1.0_0", "true_handheld_0.6_1", "true_sway_1.0_1")
MORE_FORGED += ("patchy_sway_0.6_1", "randomwalk_sway_0.6_1", "frozen_handheld_0.6_0", "drift_handheld_0.6_0")
#: Formats with four outside films each, and two fronts of the board.
FORMATS, OF_EACH = outside_films.FORMATS, 4
FRONTS = {"hex": ("--axes", "hex"), "edge": ("--markers", "frame")}
BUILDS = {f"page_{scale}": {"page": scale} for scale in (0.96, 0.98, 1.02, 1.04)}
BUILDS |= {f"sheet_{scale}": {"sheet": scale} for scale in (0.984, 0.988, 1.012, 1.0333)}
BUILDS |= {f"air_{mm}_{low}": {"air": mm, "view": (low, low + 13)} for mm in (0.05, 0.2) for low in (2, 39)}
MOVES, LENSES_A_MOVE = ("flat", "sway", "arc"), 4
#: Of this version's command, whichever is installed.
PRINT = "from moireid.cli.main import print_your_badge; print_your_badge()"
DATA = Path(natural_films.__file__).parents[1] / "tests" / "data" / "films"


def by_simulator(
    path: Path, *, motion: str, metres: float, seed: int, forge: str | None = None, effect: str | None = None
) -> None:
    """A film by `moireid.simulate`."""
    badge = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_from_hex("7097c67b0fafc59b"))
    phone = camera_named("phone")
    camera = replace(phone, width=SIZE[0], height=SIZE[1], focal_px=phone.focal_px * NEARER)
    scene, way = Scene(badge, Build.typical(seed), camera), motion_named(motion, distance_mm=1000 * metres, seed=seed)
    effects = [effect_named(effect)] if effect else []
    simulated(scene, way, path, frames=FRAMES, fps=float(FPS), forge=forge, effects=effects, seed=seed)
    path.with_suffix(".json").write_text(badge.to_json(), encoding="utf-8")


def outside(path: Path, *, motion: str, metres: float) -> None:
    """A printed board by the outside tracer, on a measured motion."""
    rng = np.random.default_rng([*path.stem.encode(), 1])
    board = natural_films.prepared(path.parent / "board") / "badge"
    page, camera = load_page(board), drawn(rng, SIZE)
    way = course(motion, 1000 * metres, FRAMES / FPS, rng)
    _traced(path, board, page, built(page, rng), camera, way, rng)


def of_format(path: Path, *, name: str, number: int, front: str | None = None) -> None:
    """A badge of a format, as it is printed for its wearer, by the outside tracer."""
    task = outside_films.Task(name, number, number, 0.0, 1, OF_EACH)
    if front:
        outside_films.WEAR = (FRONTS[front],)
    rng, folder = np.random.default_rng(task.seed), path.parent / path.stem
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    outside_films.issued(task, folder)
    near, far = load_badge(folder / "badge" / "badge.json").range_m
    page, camera = load_page(folder / "badge", edge_to_edge=front == "edge"), drawn(rng, SIZE)
    metres = NEARER * (near + (number + 0.5) / OF_EACH * 0.7 * (far - near))
    way = course(outside_films.MOTIONS[number % 3], 1000 * metres, FRAMES / FPS, rng)
    _traced(path, folder / "badge", page, built(page, rng), camera, way, rng)


def of_any_lens(path: Path, *, case: dict[str, object]) -> None:
    """A board that was built wrong, or is seen through a long lens, by the outside tracer."""
    rng = np.random.default_rng([*path.stem.encode(), 11])
    board = natural_films.prepared(path.parent / "board") / "badge"
    page = flawed(load_page(board), Flaws(air_mm=case.get("air", 0.0)), 1)
    camera, way = any_lens.camera_and_course(case, page.size_mm[0], rng)
    _traced(path, board, page, any_lens.misbuilt(built(page, rng), case), camera, way, rng)


def _traced(path: Path, badge: Path, page, build, camera, way, rng) -> None:  # type: ignore[no-untyped-def]
    traced(page, build, camera, way, path, Shoot(FRAMES, FPS, 23, int(rng.integers(1 << 30))))
    path.with_suffix(".course.csv").unlink()
    shutil.copyfile(badge / "badge.json", path.with_suffix(".json"))


def copied(path: Path, *, film: str, badge: str) -> None:
    """A film of the tests, with the badge that it claims."""
    shutil.copyfile(DATA / film, path)
    shutil.copyfile(DATA / badge, path.with_suffix(".json"))


def cases() -> dict[str, Callable[[Path], None]]:
    """What makes each film, by name; its first word is the part of the corpus."""
    rows = csv.DictReader((DATA / "collection.csv").read_text(encoding="utf-8").splitlines())
    found: dict[str, Callable[[Path], None]] = {
        f"data-{row['video'].removesuffix('.mp4')}": partial(copied, film=row["video"], badge=row["claim"])
        for row in rows
    }
    forged = [f"{kind}_{motion}_{metres}_{seed}" for motion, metres, seed in FORGED for kind in FORGERIES]
    for name in (*forged, *MORE_FORGED):
        kind, motion, metres, seed = name.rsplit("_", 3)
        how = {"motion": motion, "metres": float(metres), "seed": int(seed)}
        found[f"forged-{name}"] = partial(by_simulator, forge=None if kind == "true" else kind, **how)
    for effect in (*EFFECTS, "call:strong", "jello:strong"):
        how = {"motion": "handheld", "metres": NEARER, "seed": 3, "effect": effect}
        found[f"effect-{effect.replace(':', '_')}"] = partial(by_simulator, **how)
    for motion in natural_films.MOTIONS:
        for metres in (1.0, 1.5):
            for number in range(5):
                way = partial(outside, motion=motion, metres=round(NEARER * metres, 3))
                found[f"natural-{motion}_{metres}_{number}"] = way
    wanted = [(name, number, None) for number in range(OF_EACH) for name in FORMATS]
    for name, number, front in [*wanted, *(("board", 1, front) for front in FRONTS)]:
        found[f"format-{name}_{front or number}"] = partial(of_format, name=name, number=number, front=front)
    found |= {f"build-{name}": partial(of_any_lens, case=case) for name, case in BUILDS.items()}
    for move in MOVES:
        found |= {f"lens-{move}_{n}": partial(of_any_lens, case={"move": move}) for n in range(LENSES_A_MOVE)}
    return found


def made(name: str, folder: Path) -> str:
    """Make a film, unless it is there, and move it to its place once it is whole."""
    scratch = folder / "scratch"
    any_lens.PHONE, any_lens.FRAMES = SIZE, FRAMES
    natural_films.PROGRAM = outside_films.PROGRAM = folder / "print-your-badge"
    if not (folder / f"{name}.mp4").exists():
        for stale in scratch.glob(f"{name}.*"):
            stale.unlink()
        try:
            cases()[name](scratch / f"{name}.mp4")
        except SpecError as error:
            # Such as a drift on a motion that is steady.
            return f"{name} is not made: {error}"
        for suffix in (".json", ".mp4"):
            (scratch / f"{name}{suffix}").rename(folder / f"{name}{suffix}")
    return name


def main(folder: Path, only: str, workers: int) -> None:
    """Make the films that match."""
    folder.mkdir(parents=True, exist_ok=True)
    program = folder / "print-your-badge"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -P -c "{PRINT}" "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    natural_films.PROGRAM = program
    (folder / "scratch").mkdir(exist_ok=True)
    natural_films.prepared(folder / "scratch" / "board")
    wanted = [name for name in cases() if re.search(only, name)]
    with ProcessPoolExecutor(workers) as pool:
        for number, name in enumerate(pool.map(partial(made, folder=folder), wanted), start=1):
            print(f"{number} of {len(wanted)}: {name}", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
