"""The natural suite, with its table and plot: verdicts on parts of 4 to 40 s of films with measured motions.

A true badge is filmed with each motion at 1 m and 2 m.

Convention: a film is tracked once, by `verify` with the badge as claim and its identity, not known as built.  Its track
is cut, and each part is judged as a chapter of its own.  The verdict of a row is the motion's.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from moireid.designer import Order, design_badge
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import Question, verify
from moireid.verifier.session.chapters import judge_chapter
from moireid.verifier.tracking.track import Track
from moireid_lab.bench.bench_frame import Bench, Row, Wish, counted_verdicts, grouped, temporary_film
from moireid_lab.bench.bench_plots import figure_of, plain

#: Two measured motions, and one that is made.
MOTIONS = ("walk", "handheld", "sway")
DISTANCES_M = (1.0, 2.0)
#: Lengths of the parts that are judged, s.
LENGTHS_S = (4, 7, 10, 20, 40)
QUICK_LENGTHS_S = (4, 10)


@dataclass(frozen=True)
class NaturalCase:
    """motion: of `simulate.motion`; distance_m: mean distance of camera and badge, m."""

    motion: str
    distance_m: float

    @property
    def name(self) -> str:
        """As `--only` matches it and rows are kept by it."""
        return f"{self.motion} {self.distance_m:g} m"


def cases() -> list[NaturalCase]:
    """All of them."""
    return [NaturalCase(motion, distance) for motion in MOTIONS for distance in DISTANCES_M]


def usual(case: NaturalCase, *, quick: bool) -> bool:
    """Whether a case is filmed unless asked for by name; quick: the walk at 1 m alone."""
    return not quick or (case.motion, case.distance_m) == (MOTIONS[0], DISTANCES_M[0])


#: Parts of one length.
MOST_PARTS = 4


def part_starts(lengths_s: Sequence[int], film_s: float) -> dict[int, list[int]]:
    """Where the parts of each length begin in a film.

    Parameters
    ----------
    lengths_s : sequence of int
        Lengths of the parts, s; those longer than the film are left out.
    film_s : float
        Length of the film, s.

    Returns
    -------
    dict of int to list of int
        Times from the film's begin, s, by length, the longest first.

    Notes
    -----
    Convention: parts of one length do not overlap and are `MOST_PARTS` at most; each is inside a part of every longer
        length.
    """
    found: dict[int, list[int]] = {}
    longer_s, longer_starts = film_s, [0]
    for length_s in sorted((length for length in lengths_s if length <= film_s), reverse=True):
        pieces = range(int(longer_s // length_s))
        starts = [start + piece * length_s for start in longer_starts for piece in pieces]
        found[length_s] = starts[:MOST_PARTS]
        longer_s, longer_starts = length_s, found[length_s]
    return found


def cut_track(track: Track, first: int, end: int) -> Track:
    """The track of some of a film's frames, as if the film had these alone.

    Parameters
    ----------
    track : Track
        Of the whole film.
    first, end : int
        Numbers of the first frame, and of the one after the last.

    Returns
    -------
    Track
        Its times and frame numbers are those of the whole film; it has no snapshot and no times of stages.

    Notes
    -----
    Convention: uniform strips have a row for each tracked frame, rows of phase cells one for each of `cell_frames`.
    """
    frames = (track.frame_numbers >= first) & (track.frame_numbers < end)
    cells = frames[track.cell_frames]
    return replace(
        track,
        frames_read=max(min(end, track.frames_read) - max(first, 0), 0),
        frame_numbers=track.frame_numbers[frames],
        times_s=track.times_s[frames],
        homographies=track.homographies[frames],
        correlations=track.correlations[frames],
        profiles=tuple(
            profile[frames if strip.uniform else cells]
            for strip, profile in zip(track.strips, track.profiles, strict=True)
        ),
        cell_frames=(np.cumsum(frames) - 1)[track.cell_frames[cells]],
        snapshot=None,
        vague=None if track.vague is None else track.vague[frames],
        stages_s={},
    )


PAYLOAD = bytes.fromhex("0f5ac3962d784be1")
FPS = 30
FRAMES = max(LENGTHS_S) * FPS
CAMERA = Camera(1280, 720, 966.7)


def run_case(job: tuple[str, int, int]) -> dict[str, Any]:
    """One film of one case; the figures of all its parts."""
    name, seed, frames = job
    case = next(case for case in cases() if case.name == name)
    badge = design_badge(Order("Bench", lens="50lpi"), PAYLOAD)
    claim = Question(badge, badge.id)
    motion = motion_named(case.motion, distance_mm=1000 * case.distance_m, seed=seed)
    scene = Scene(badge, Build.typical(seed), CAMERA)
    with temporary_film(scene, motion, frames=frames, fps=float(FPS), seed=seed) as video:
        track = verify(video, claim).track
    starts = part_starts(LENGTHS_S, frames / FPS)
    parts = [judge_part(track, claim, start, seconds) for seconds in starts for start in starts[seconds]]
    return {"case": name, "seed": seed, "parts": parts}


def judge_part(track: Track, claim: Question, start_s: int, seconds: int) -> dict[str, Any]:
    """The verdict on a part of a film, and the processor time of judging it."""
    part = cut_track(track, start_s * FPS, (start_s + seconds) * FPS)
    with threadpool_limits(limits=1, user_api="blas"):
        clock = time.process_time()
        chapter = judge_chapter(part, claim)
        judge_s = time.process_time() - clock
    motion, reasons = chapter.invariant, (*chapter.invariant.reasons, *chapter.identity.reasons)
    return {
        "seconds": seconds,
        "start_s": start_s,
        "frames": part.tracked,
        "verdict": motion.verdict,
        "score": motion.score,
        "gain": motion.gain_ratio,
        "residual_rad": motion.phase_residual_rad,
        "excitation_rad": motion.excitation_rad,
        "identity": chapter.identity.verdict,
        "why": [reason.code for reason in reasons if reason.level in ("fail", "undecided")],
        "judge_s": judge_s,
    }


def rows_of_film(found: dict[str, Any], lengths_s: tuple[int, ...]) -> list[dict[str, Any]]:
    """One row for each part of these lengths, with its film's motion, distance and seed."""
    case: NaturalCase = next(case for case in cases() if case.name == found["case"])
    film_row = {"motion": case.motion, "distance_m": case.distance_m, "seed": found["seed"]}
    return [film_row | part for part in found["parts"] if part["seconds"] in lengths_s]


def rows(wish: Wish) -> Iterator[Row]:
    """The parts of the usual films, or of those that are asked for.  Raises: SpecError where no case is left."""
    names = [case.name for case in cases() if wish.only is not None or usual(case, quick=wish.quick)]
    lengths = QUICK_LENGTHS_S if wish.quick else LENGTHS_S
    for found in wish.films(run_case, names, FRAMES, wish.seeds(5)):
        yield from rows_of_film(found, lengths)


#: Films with this much motion, rad, hold enough of it for a verdict.
ENOUGH_RAD = 0.3
#: From the worst verdict to the best one.
ORDER = ("reject", "inconclusive", "accept")
COLOURS = dict(zip(MOTIONS, ("#22577a", "#d98a3d", "#7a8a5a"), strict=True))
STYLES = dict(zip(DISTANCES_M, ("-", "--"), strict=True))


COLUMNS = {"true badge": "<16", "length": ">8", "films": ">7", "accept": ">8", "inconclusive": ">13", "reject": ">8"}
COLUMNS |= {f"of >= {ENOUGH_RAD:g} rad": ">15", "log10 odds": ">12.2f", "ms a film": ">11.0f", "ms a frame": ">12.2f"}
COLUMNS |= {"reasons": "<1"}


def table(rows: list[Row]) -> Iterator[Row]:
    """Verdicts, log odds and judge time for each motion, distance and length."""
    for (motion, distance, seconds), own in groups(rows).items():
        yield {"true badge": f"{motion:<12}{distance:>2g} m", "length": f"{seconds} s"} | part_figures(own)


def part_figures(rows: list[Row]) -> Row:
    """Verdicts, odds and times of parts of one length; "of": those accepted of the ones that move enough."""
    counted, enough = counted_verdicts(rows), with_enough_motion(rows)
    judge_s, frames = sum(row["judge_s"] for row in rows), sum(row["frames"] for row in rows)
    return {
        "films": len(rows),
        **{verdict: counted[verdict] for verdict in reversed(ORDER)},
        f"of >= {ENOUGH_RAD:g} rad": f"{sum(row['verdict'] == 'accept' for row in enough)} of {len(enough)}",
        "log10 odds": median_odds(rows),
        "ms a film": 1e3 * judge_s / len(rows),
        "ms a frame": 1e3 * judge_s / max(frames, 1),
        "reasons": counted["reasons"],
    }


def pairs_sentence(rows: list[Row]) -> str:
    """In how many nested pairs the longer part's verdict is the worse one."""
    worse, count = nested_pairs(rows)
    return f"the longer part's verdict is worse than that of a part inside it: {worse} of {count} pairs"


def groups(rows: list[Row]) -> dict[tuple[str, float, int], list[Row]]:
    """Rows by motion, distance and length, in the order of the motions."""
    found = grouped(rows, "motion", "distance_m", "seconds")
    return dict(sorted(found.items(), key=lambda one: (MOTIONS.index(one[0][0]), *one[0][1:])))


def nested_pairs(rows: list[Row]) -> tuple[int, int]:
    """Pairs of a part and a longer one around it: how many have a worse verdict on the longer one, and how many are."""
    films = grouped(rows, "motion", "distance_m", "seed")
    pairs = [(inner, outer) for parts in films.values() for inner in parts for outer in parts if _inside(inner, outer)]
    worse = sum(ORDER.index(outer["verdict"]) < ORDER.index(inner["verdict"]) for inner, outer in pairs)
    return worse, len(pairs)


def _inside(inner: Row, outer: Row) -> bool:
    """Whether a part is inside a longer one of its film."""
    begins_later = inner["start_s"] >= outer["start_s"]
    ends_earlier = inner["start_s"] + inner["seconds"] <= outer["start_s"] + outer["seconds"]
    return bool(inner["seconds"] < outer["seconds"] and begins_later and ends_earlier)


def accepted_share(rows: list[Row]) -> float:
    """Share of the rows that are accepted, 0 to 1."""
    return float(np.mean([row["verdict"] == "accept" for row in rows]))


def median_odds(rows: list[Row]) -> float:
    """Median of the log10 odds, over the rows that have them; nan without any."""
    scores = [row["score"] for row in rows if row["score"] is not None]
    return float(np.median(scores)) if scores else float("nan")


def with_enough_motion(rows: list[Row]) -> list[Row]:
    """The rows with at least `ENOUGH_RAD` of motion."""
    return [row for row in rows if (row["excitation_rad"] or 0.0) >= ENOUGH_RAD]


def plot(rows: list[Row]) -> Any:
    """Share of accepted parts and median log10 odds against the parts' length, a line for each motion and distance."""
    found = groups(rows)
    figure = figure_of(9, 3.6)
    shares, odds = figure.subplots(1, 2)
    lengths = sorted({seconds for _, _, seconds in found})
    for motion, distance in dict.fromkeys((motion, distance) for motion, distance, _ in found):
        own = {seconds: rows for (*film, seconds), rows in found.items() if film == [motion, distance]}
        look = {"color": COLOURS[motion], "ls": STYLES[distance], "marker": "o", "ms": 4}
        for axes, measure in ((shares, accepted_share), (odds, median_odds)):
            axes.plot(list(own), [measure(rows) for rows in own.values()], label=f"{motion} {distance:g} m", **look)
    for axes, label in ((shares, "share accepted"), (odds, "median log10 odds")):
        axes.set(xlabel="length, s", ylabel=label, xscale="log")
        axes.set_xticks(lengths, [str(seconds) for seconds in lengths])
        axes.minorticks_off()
        plain(axes)
    shares.set_ylim(-0.05, 1.05)
    figure.legend(handles=shares.lines, frameon=False, ncols=6, loc="outside upper center", fontsize=8)
    return figure


BENCH = Bench(rows, COLUMNS, lambda rows: [pairs_sentence(rows)], table=table, plot=plot)
