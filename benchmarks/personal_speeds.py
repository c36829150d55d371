"""What a personal speed of each row would buy: run `.venv/bin/python benchmarks/personal_speeds.py --builds DIR`.

If the pitch of the lines ran from 0.495 to 0.535 mm over a badge (a chirp), its rows would move at speeds that differ
by some per cent, and the ratio of two speeds owes nothing to the camera's focal length or to common errors of its pose.
Two questions decide whether that is worth it.

1. *Motion.* How much do the speeds of rows differ on true films of badges whose rows are alike?  `--builds` is a
   folder that `benchmarks/builds.py --keep` filled.  Printed, kind by kind, is the difference between the speeds of the
   top and the bottom row, as a share, over all true films; and how many times as large the chirp's own difference is.
   Fringes that move as one lack that difference.
2. *Donors.* Who re-badges a film copies rows of a donor's true film to rows of the victim, any to any.  Printed is how
   far the worst row's speed is off with the best of 100 random donors whose badges have chirps of their own, and the
   share of forgers with 1 and with 100 donors who keep within the scatter of question 1.  A printed copy has all rows.

Convention: speeds are of fringes at points of the printed page, where the markers are: g / p_f - (g - g_eff) / p_r.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.badge import load_badge
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped, run_script

Array = NDArray[np.float64]
LENS_PITCH_MM, ENDS_MM, ROWS = 0.508, (0.495, 0.535), 12
#: Effective over optical gap, `g_eff / g`, of the prototype: traced.
GAP_SHARE = 0.60
DONORS, TRIALS = 100, 300
#: Rows farther off than this share would be seen where rows are as alike as on flat builds; the second, on usual ones.
ROOMS = (0.005, 0.02)


def speed(pitch_mm: Array) -> Array:
    """Speed of the fringes on the page over that at the lens pitch."""
    return (1 / LENS_PITCH_MM - (1 - GAP_SHARE) / pitch_mm) / (GAP_SHARE / LENS_PITCH_MM)


def row_speeds(film: Path) -> Array | None:
    """How much faster than the mean each plain row of a true film moves, top to bottom, as shares; None if it is read
    in less than two rows.
    """
    badge = load_badge(film.parent / "badge" / "badge.json")
    report = verify(film, Claim(badge, badge.id))
    if report.measurement is None or not report.measurement.gratings:
        return None
    signal, found = report.measurement.gratings[0], []
    used = np.isfinite(signal.phase_sd_rad)
    moved = signal.predicted_rad[used] - signal.predicted_rad[used].mean()
    for strip in report.measurement.strips:
        if strip is None:
            continue
        turn = np.exp(1j * (strip.phase_rad - signal.measured_rad))[used]
        apart = np.angle(turn / turn.mean())
        found.append(float(apart @ moved / (moved @ moved)))
    return np.array(found) if len(found) > 1 else None


def motion_row(job: tuple[str, list[Path]]) -> Row:
    """The scatter of one kind of builds."""
    kind, films = job
    found = [speeds for film in films if (speeds := row_speeds(film)) is not None]
    apart = np.array([speeds[0] - speeds[-1] for speeds in found])
    scatter = float(np.sqrt(np.mean(apart**2)))
    chirp = float(np.ptp(speed(np.array(ENDS_MM))))
    worst = float(np.abs(apart).max())
    return {"kind": kind, "films": len(found), "rms": scatter, "most": worst, "chirp over rms": chirp / scatter}


def chirps(rng: np.random.Generator, count: int) -> Array:
    """Pitches of the rows of so many personal badges, (count, ROWS): smooth, each over a part of the whole range."""
    ends = np.sort(rng.uniform(*ENDS_MM, (count, 2)), axis=1)
    bent = np.linspace(0, 1, ROWS) ** np.exp(rng.uniform(-1, 1, (count, 1)))
    pitches = ends[:, :1] + bent * np.diff(ends, axis=1)
    return np.where(rng.random((count, 1)) < 0.5, pitches, pitches[:, ::-1])


def worst_row(victim: Array, donors: Array) -> Array:
    """How far the worst row's speed is off with each donor, whose rows may go to any row; the level is free."""
    asked, there = speed(victim), speed(donors)
    apart = np.abs(there[:, :, None] - asked[None, None, :]).min(axis=1)
    return np.asarray(apart.max(axis=1))


def donor_row(kind: str) -> Row:
    """The best of so many donors, over many victims."""
    rng = np.random.default_rng(34)
    best = np.empty((TRIALS, 2))
    for number in range(TRIALS):
        victim, *donors = chirps(rng, DONORS + 1)
        off = worst_row(victim, np.array(donors))
        best[number] = off[0], off.min()
    row: Row = {"kind": kind, "median of 1": float(np.median(best[:, 0])), "of 100": float(np.median(best[:, 1]))}
    for room in ROOMS:
        row[f"1 within {room:.1%}"] = float((best[:, 0] < room).mean())
        row[f"100 within {room:.1%}"] = float((best[:, 1] < room).mean())
    return row


def rows(wish: Wish) -> Iterator[Row]:
    """Kinds of builds, then donors."""
    if wish.own.builds is not None:
        films = sorted(Path(wish.own.builds).rglob("*_true.mp4"))
        films = [path for path in films if (path.parent / "badge" / "badge.json").exists()]
        named = [{"kind": path.name.rsplit("_", 3)[0].replace("_", " "), "film": path} for path in films]
        jobs = {kind: (kind, [one["film"] for one in own]) for kind, own in grouped(named, "kind").items()}
        yield from wish.each(motion_row, jobs)
    yield donor_row("donors")


COLUMNS = {"kind": "<22", "films": ">5", "rms": ">8.4f", "most": ">8.4f", "chirp over rms": ">14.1f"}
COLUMNS |= {"median of 1": ">11.4f", "of 100": ">8.4f"}
COLUMNS |= {f"{count} within {room:.1%}": ">15.0%" for room in ROOMS for count in (1, DONORS)}
OPTIONS = {"--builds": {"metavar": "DIR", "help": "films of builds that `benchmarks/builds.py --keep` left"}}
BENCH = Bench(rows, COLUMNS, options=OPTIONS)

if __name__ == "__main__":
    run_script(__file__)
