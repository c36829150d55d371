"""The reality suite: films as phones, editors, calls and services change them.

Each effect is filmed at 1 m and 2 m, at its ordinary strength of a true badge and, once at each distance, of a forged
one; the two that calls and shutters have most of also at their strongest.  `--clips` films each that often.

Convention: a film is judged by `verify` with the badge as claim and its identity, not known as built.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from moireid.designer import Order, design_badge
from moireid.simulate.effects.table import KINDS, effect_named
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.part import OWN, Asked, Part, Row, film_row, interleaved, temporary_film

#: The first row: a film to which nothing was done.
NOTHING = "none"
DISTANCES_M = (1.0, 2.0)
FORGERIES = ("gain_low", "wobble", "drift", "reversed")
STRONG = ("call:strong", "jello:strong")


@dataclass(frozen=True)
class EffectCase:
    """effect: of `simulate.effects`, or none; forge: kind of the forgery, None for a true badge; motion: by name."""

    effect: str
    distance_m: float
    forge: str | None
    motion: str
    seed: int

    @property
    def name(self) -> str:
        """As `--only` matches it and rows are kept by it."""
        return f"{self.effect} {self.distance_m:g} m {self.forge or 'true'}|{self.seed}"


def cases(asked: Asked) -> dict[str, EffectCase]:
    """All of them."""
    effects, seeds = [NOTHING, *KINDS, *STRONG], range(asked.clips or 1)
    found: list[dict[str, EffectCase]] = []
    for true in (True, False):
        some = [
            EffectCase(
                effect,
                distance,
                None if true else FORGERIES[(k + far) % len(FORGERIES)],
                MOTIONS[(k + seed) % len(MOTIONS)],
                seed,
            )
            for seed in seeds
            for far, distance in enumerate(DISTANCES_M)
            for k, effect in enumerate(effects)
        ]
        found.append({case.name: case for case in some})
    return interleaved(*found)


PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FRAMES, FPS = 240, 30.0
MOTIONS = ("sway", "handheld", "linear")
CAMERA = Camera(1280, 720, 966.7)


def judged(case: EffectCase, folder: Path) -> Row:
    """One film: of a body that sways before a camera on a tripod, a hand-held camera, or one moved to and fro."""
    badge, seed = design_badge(Order("Bench", lens="50lpi"), PAYLOAD), case.seed
    motion = motion_named(case.motion, distance_mm=1000 * case.distance_m, seed=seed)
    scene = Scene(badge, Build.typical(seed), CAMERA)
    effects = [] if case.effect == NOTHING else [effect_named(case.effect)]
    with temporary_film(scene, motion, frames=FRAMES, fps=FPS, seed=seed, forge=case.forge, effects=effects) as video:
        report = verify(video, Question(badge, badge.id))
    true = case.forge is None
    kind = case.effect if true else f"forged, {case.distance_m:g} m"
    return film_row(kind, report, true=true, question="" if not true else f"at {case.distance_m:g} m")


QUESTIONS = {
    "at 1 m": "Is a true film accepted, whatever phones, editors and calls do to it? At 1 m",
    "at 2 m": "The same at 2 m, where a marker is 13 px wide",
    "forged": "Is a forged film rejected under the same effects?",
}
PART = Part(QUESTIONS, OWN, cases, judged, 6)
