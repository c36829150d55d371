"""Badges as people build them, by an outside tracer: run `moireid lab bench builds [--clips N]`.

Each badge is printed as `print-your-badge` does, and traced by `outside`, which shares nothing with
`moireid.simulate`, with one flaw of print, sheet, shape or light, or with all that is usual (`outside.flaws`,
`outside.lamps`).  It is enrolled from two films, filmed again at the middle of its range, and filmed with half the
gain; a second build of the same files, with the same flaws of another draw, is the copy.  Narrowed: printed for
a printer that widens lines.  Figures are how many error bars the enrolled gain is off that of the build's own lenses,
traced; and how far the map of places of the original and of the copy is off that of enrolment (rad, root mean square).
With `--clips N` N badges of each kind are built, filmed on other motions; `--keep DIR` keeps films and reports.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from natural_films import prepared
from outside.build import built
from outside.camera import PHONE, drawn
from outside.film import Shoot, film
from outside.flaws import Flaws, flawed
from outside.lamps import lamps_about
from outside.lens import through_cylinders
from outside.motion import KINDS as MOTIONS
from outside.motion import course
from outside.page import Lens, load_page

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge, load_badge
from moireid.errors import MediaError
from moireid.verifier import Question, Report, verify
from moireid.verifier.session.capture import capture_as_built
from moireid_lab.bench.part import INCONCLUSIVE, OUTSIDE, Asked, Part, Row, answer_of, numbered, why_not

FRAMES, FPS, DISTANCE_MM = 240, 30, 1000.0
#: A second build of the same files has this number more.
COPY = 100
KINDS = {
    "none": Flaws(),
    "ink 42 um": Flaws(ink_um=42),
    "ink 85 um": Flaws(ink_um=85),
    "ink 85 um, narrowed": Flaws(ink_um=85),
    "bands 3 %": Flaws(bands=0.03),
    "bled and bands": Flaws(ink_um=42, bands=0.03),
    "focus 1.07": Flaws(focus=1.07),
    "focus 1.47": Flaws(focus=1.47),
    "ellipse": Flaws(ellipse=True),
    "gradient 0.2 %": Flaws(gradient=0.002),
    "air 0.05 mm": Flaws(air_mm=0.05),
    "air 0.15 mm": Flaws(air_mm=0.15),
    "air in waves": Flaws(air_mm=0.05, waves_mm=0.04),
    "wander 0.02 mm": Flaws(wander_mm=0.02),
    "wander 0.05 mm": Flaws(wander_mm=0.05),
    "haze 30 %": Flaws(haze=0.3),
    "haze 60 %": Flaws(haze=0.6),
    "bow 1.5 m": Flaws(bow_m=1.5),
    "bow 0.7 m": Flaws(bow_m=0.7),
    "bow 0.35 m": Flaws(bow_m=0.35),
    "bow 0.35 m, upright": Flaws(bow_m=0.35, bow_deg=90),
    "bow 0.35 m, level": Flaws(bow_m=0.35, bow_deg=0),
    "hollow 0.7 m": Flaws(bow_m=-0.7),
    "twist 0.5 / m": Flaws(twist_per_m=0.5),
    "glare": Flaws(),
    "side light": Flaws(),
    "usual": Flaws(
        ink_um=30, bands=0.01, focus=1.07, air_mm=0.05, waves_mm=0.04, wander_mm=0.02, haze=0.3, bow_m=1.5
    ),
}  # fmt: skip
#: Of these kinds: the share of light from the side, and what lenses mirror at most over the light of white card.
LAMPS = {"glare": (0.0, 0.6), "side light": (0.9, 0.0), "usual": (0.9, 0.3)}


def badge_folder(folder: Path, kind: str, build: int) -> Path:
    """Where the badge and the films of a build are; another number is another badge, a copy is of the same."""
    if kind.endswith("narrowed"):
        return prepared(folder / "narrowed", ink_growth_um=85.0)
    number = build % COPY
    payload = np.random.default_rng([number, 7]).bytes(8).hex()
    return prepared(folder / f"badge_{number}", payload=payload) if number > 1 else prepared(folder)


def filmed(folder: Path, kind: str, build: int, number: int, forge: str | None = None) -> Path:
    """One film of one build; kept in the folder."""
    name = kind.replace(" ", "_").replace("%", "pc").replace("/", "per").replace(",", "")
    path = folder / f"{name}_{build}_{number}_{forge or 'true'}.mp4"
    if not path.exists():
        rng = np.random.default_rng([build, number, 5])
        page = flawed(load_page(folder / "badge"), KINDS[kind], build)
        motion = course(MOTIONS[(number + build % COPY - 1) % 3], DISTANCE_MM, FRAMES / FPS, rng)
        own = built(page, np.random.default_rng([build, 6]))
        camera, light = drawn(rng, PHONE), LAMPS.get(kind)
        lamps = lamps_about(motion, FRAMES / FPS, *light, rng) if light else None
        shoot = Shoot(FRAMES, FPS, 23, number, forge, lamps)
        scratch = path.with_suffix(".part.mp4")
        film(page, own, camera, motion, scratch, shoot)
        scratch.rename(path)
    return path


def traced_gain(kind: str, build: int, folder: Path) -> float:
    """How much further fringes move under the build's lenses than under those of the design, at small angles."""
    plain = load_page(folder / "badge")
    return _fringe_rad(flawed(plain, KINDS[kind], build).lens, 0.05) / _fringe_rad(plain.lens, 0.05)


def _fringe_rad(lens: Lens, tangent: float) -> float:
    """Phase of the fringes seen through a whole lens at that tangent of view, lines being as wide as lenses."""
    count = 4000
    landed, along, share = (np.arange(count) + 0.5) / count * lens.pitch_mm, np.zeros(count), np.empty(count)
    slopes, conic = (np.full(count, tangent), np.zeros(count)), (lens.conic,) if lens.conic else ()
    figures = lens.pitch_mm, lens.radius_mm, lens.thickness_mm, lens.index, lens.air_mm, *conic
    through_cylinders(count, landed, along, *slopes, share, 0.0, *figures)
    return float(np.angle(np.sum(share * np.exp(2j * np.pi * (landed / lens.pitch_mm - 0.5)))))


def enrolled(films: list[Path], badge: Badge) -> AsBuilt | str:
    """As-built figures of two films, or why they are refused."""
    try:
        return capture_as_built(films, badge)
    except MediaError as error:
        return str(error).split("cannot be used:")[-1].strip()


def verdict(path: Path, claim: Question, stage: str) -> tuple[Report, float | None]:
    """Report and the map's difference of a film; the report is kept next to it."""
    report = verify(path, claim)
    path.with_suffix(f".{stage}.json").write_text(json.dumps(report.to_json(), indent=1), encoding="utf-8")
    return report, next((reason.measured for reason in report.reasons if reason.code == "as_built_map"), None)


def judged(job: tuple[str, int], folder: Path) -> Row:
    """One build: filmed, enrolled, judged."""
    kind, build = job
    folder = badge_folder(folder, kind, build)
    badge = load_badge(folder / "badge" / "badge.json")
    films = [filmed(folder, kind, build, number) for number in range(3)]
    before, _ = verdict(films[2], Question(badge, badge.id), "before")
    row: Row = {"kind": kind, "answers": {"before": answer_of(before.verdict, true=True)}, "why": why_not(before)}
    figures = enrolled(films[:2], badge)
    if isinstance(figures, str):
        return row | {"refused": figures, "answers": row["answers"] | {"after": INCONCLUSIVE}}
    claim = Question(badge, badge.id, as_built=figures)
    (after, off), (copy, copy_off), (lie, _) = (
        verdict(path, claim, "after")
        for path in (films[2], filmed(folder, kind, build + COPY, 2), filmed(folder, kind, build, 2, "gain_0.5"))
    )
    row["answers"] |= {"after": answer_of(after.verdict, true=True), "copy": answer_of(copy.verdict, true=False)}
    row["answers"] |= {"half gain": answer_of(lie.verdict, true=False)}
    bars = (figures.gain_ratio - traced_gain(kind, build, folder)) / figures.gain_sd
    row |= {"enrolled gain": figures.gain_ratio, "bars off": bars, "gain": after.invariant.gain_ratio}
    return row | {"why": why_not(after), "map off": off, "copy's map off": copy_off}


def cases(asked: Asked) -> dict[str, tuple[str, int]]:
    """All builds."""
    return numbered(list(KINDS), asked.clips or 1, 1)


QUESTIONS = {
    "before": "Is a badge accepted as people build it, not enrolled?",
    "after": "The same once it is enrolled from two films?",
    "copy": "Is a second build of the same files rejected then?",
    "half gain": "Is a film with half the gain rejected then?",
}
PART = Part(QUESTIONS, OUTSIDE, cases, judged)
