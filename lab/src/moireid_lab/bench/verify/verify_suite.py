"""The verify suite, with its table and plot.

Error against run time of the verifier, and its verdicts on stiff and extreme motions (`motion_extremes`).

work: on films of known truth, every setting of frames used, working resolution and estimator: error of the fringe
    phase, of the phase that the poses predict, and of the gain; verdicts that are right; milliseconds of a film's
    frame, decoding apart.
knee: the setting of least phase error times run time among those whose verdicts are all right.

A setting changes only the frames: they are skipped or shrunk before they are pushed into `verifier.Verifier`.  The time
for shrinking counts for the setting.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from moireid.verifier import KnownCamera, Question, Verifier
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.reasons import worst
from moireid.verifier.session.badge_session import reasons_of
from moireid.verifier.session.chapters import invariant_of
from moireid_lab.baseline.pipeline import PublishedReader, judge
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped
from moireid_lab.bench.bench_plots import error_against_time
from moireid_lab.bench.bench_rows import Where
from moireid_lab.bench.verify.films import KINDS, DecodedFilm, Kind, phase_error_rad, shoot
from moireid_lab.bench.verify.motion_extremes import extreme_jobs, read_extreme

#: 8 s, so that every fourth frame is still more than the verifier asks for at least.
FRAMES, QUICK_FRAMES = 250, 150
RUNS, QUICK_RUNS = 3, 2
EVERY, SCALES = (1, 2, 3, 4), (1.0, 3 / 4, 1 / 2, 1 / 3)
ESTIMATORS = ("ours", "focal length given", "published")
QUICK_KINDS = (KINDS[1], KINDS[-1])


@dataclass(frozen=True)
class EstimatorSetting:
    """Which frames are used, at which share of the film's resolution, and by which estimator; default: ours.

    focal length given: by the user.
    published: `evaluation.baseline.published`.
    """

    every: int = 1
    scale: float = 1.0
    estimator: str = "ours"


DEFAULT = EstimatorSetting()


def settings(*, quick: bool) -> list[EstimatorSetting]:
    """All settings: every number of frames at every resolution by our estimator, and the others as films come."""
    others = [EstimatorSetting(estimator=name) for name in ESTIMATORS[1:]]
    if quick:
        return [DEFAULT, EstimatorSetting(2), EstimatorSetting(4), EstimatorSetting(1, 1 / 2), others[0], others[-1]]
    return [EstimatorSetting(every, scale) for scale in SCALES for every in EVERY] + others


def rows(wish: Wish) -> Iterator[Row]:
    """A row for each film and setting, timed one after the other; then one for each extreme motion."""
    kinds = {kind.name: (kind, wish.quick, wish.seed) for kind in (QUICK_KINDS if wish.quick else KINDS)}
    for film in replace(wish, only=None, where=Where(workers=1)).each(swept, kinds):
        yield from film["settings"]
    yield from replace(wish, only=None).each(read_extreme, extreme_jobs(quick=wish.quick, seed=wish.seed))


def swept(job: tuple[Kind, bool, int]) -> Row:
    """One film by all settings; forged films are judged once, because only the times of true films are used."""
    kind, quick, seed = job
    frames, runs = (QUICK_FRAMES, QUICK_RUNS) if quick else (FRAMES, RUNS)
    # Children of the engine are limited to one thread; a user's process is not.
    cv2.setNumThreads(max(cv2.getNumberOfCPUs(), 2))
    with tempfile.TemporaryDirectory() as folder:
        filmed = shoot(kind, frames, seed, Path(folder))
    timed(filmed, DEFAULT, 1)  # Tables that a process makes once are made here, and not while a setting is timed.
    return {"settings": [timed(filmed, setting, 1 if kind.forge else runs) for setting in settings(quick=quick)]}


def timed(filmed: DecodedFilm, setting: EstimatorSetting, runs: int) -> dict[str, Any]:
    """One row: figures of the film, and the time of repeated runs in this process."""
    read = _published if setting.estimator == "published" else _ours
    wall, cpu, row = [], [], dict[str, Any]()
    for _ in range(runs):
        clock, used = time.perf_counter(), time.process_time()
        row = read(filmed, setting)
        wall.append(1e3 * (time.perf_counter() - clock) / len(filmed.frames))
        cpu.append(1e3 * (time.process_time() - used) / len(filmed.frames))
    true = filmed.kind.forge is None
    return {
        "film": filmed.kind.name,
        "forge": filmed.kind.forge,
        "setting": asdict(setting),
        **row,
        "right": (row["verdict"] == "accept") == true,
        "runs": runs,
        "ms": wall,
        "cpu_ms": cpu,
        "decode_ms": filmed.decode_ms,
        "decode_cpu_ms": filmed.decode_cpu_ms,
    }


def used_frames(frames: list[Frame], setting: EstimatorSetting) -> Iterator[Frame]:
    """The frames of a setting, numbered as a film of them would be; shrunk by averaging, which moves no centre."""
    for index, frame in enumerate(frames[:: setting.every]):
        picture = frame.picture
        if setting.scale != 1:
            size = (round(picture.shape[1] * setting.scale), round(picture.shape[0] * setting.scale))
            picture = Picture(np.asarray(cv2.resize(picture.whole, size, interpolation=cv2.INTER_AREA), np.uint8))
        yield Frame(index, frame.time_s, picture)


def _ours(filmed: DecodedFilm, setting: EstimatorSetting) -> dict[str, Any]:
    """Our verifier's figures of one film."""
    badge, truth = filmed.badge, filmed.truth
    given = setting.estimator == "focal length given"
    camera = KnownCamera(filmed.focal_px * setting.scale) if given else None
    verifier = Verifier(Question(badge, badge.id, camera=camera), running=False)
    for frame in used_frames(filmed.frames, setting):
        verifier.push(frame)
    chapters = verifier.finish()
    reasons, invariant = reasons_of(chapters), invariant_of(chapters)
    row = {
        "verdict": worst(list(reasons)),
        "against": [reason.code for reason in reasons if reason.level in ("fail", "undecided")],
        "tracked": sum(chapter.tracked for chapter in chapters),
        "phase_rad": None,
        "pose_rad": None,
        "gain_error": None,
    }
    measurement = chapters[0].measurement
    if measurement is None:
        return row
    signal = measurement.gratings[0]
    used = np.isfinite(signal.phase_sd_rad)
    times, gain = measurement.times_s[used], invariant.gain_ratio
    return row | {
        "phase_rad": phase_error_rad(times, signal.measured_rad[used], truth.times_s, truth.shown_rad),
        "pose_rad": phase_error_rad(times, signal.predicted_rad[used], truth.times_s, truth.law_rad),
        "gain_error": None if gain is None else gain - truth.gain,
    }


def _published(filmed: DecodedFilm, setting: EstimatorSetting) -> dict[str, Any]:
    """The published pipeline's figures of one film; its phase has no sign, so the better sign is taken."""
    truth, height, width = filmed.truth, *filmed.frames[0].luma.shape
    reader = PublishedReader(filmed.badge, None, (width, height), None)
    times: list[float] = []
    for frame in used_frames(filmed.frames, setting):
        reader.push(frame.index, frame.luma)
        times += [frame.time_s] * (len(reader.phases) - len(times))
    phase = np.unwrap(reader.phases)
    invariant = judge(phase, np.array(reader.places), len(filmed.frames))
    errors = [phase_error_rad(np.array(times), way * phase, truth.times_s, truth.shown_rad) for way in (1, -1)]
    return {
        "verdict": invariant.verdict,
        "against": [one.code for one in invariant.reasons if one.level != "pass"],
        "tracked": len(times),
        "phase_rad": min((e for e in errors if e is not None), default=None),
        "pose_rad": None,
        "gain_error": None,
    }


def _summary(setting: EstimatorSetting, films: list[dict[str, Any]]) -> dict[str, Any]:
    """One setting over all films: errors as root mean squares, times as medians over all runs of the true films.

    A film without a phase has no error, so errors can be compared only where `right` is all films.
    """
    rows = [row for row in films if row["setting"] == asdict(setting)]
    true = [row for row in rows if row["forge"] is None]
    found: dict[str, Any] = {
        "setting": asdict(setting),
        "default": setting == DEFAULT,
        "films": len(rows),
        **{name: _rms([row[name] for row in rows]) for name in ("phase_rad", "pose_rad", "gain_error")},
        "right": sum(row["right"] for row in rows),
        "rejected_true": sum(row["verdict"] == "reject" for row in true),
        "accepted_forged": sum(row["verdict"] == "accept" for row in rows if row["forge"]),
    }
    for name, decoding in (("ms", "decode_ms"), ("cpu_ms", "decode_cpu_ms")):
        low, middle, high = np.percentile([each for row in true for each in row[name]], [25, 50, 75])
        ratio = np.median([np.median(row[name]) / row[decoding] for row in true])
        found |= {name: float(middle), f"{name}_spread": float(high - low), f"{name}_to_decoding": float(ratio)}
    return found


def _rms(values: list[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.sqrt(np.mean(np.square(known)))) if known else None


def knee_of(work: list[dict[str, Any]]) -> dict[str, Any] | None:
    """The setting at the knee, of our own pipeline as films come; None where none judges all films right.

    Convention: least error times run time, where the slope of error against time, both log, is -1: before it a halved
    error costs less than twice the time, after it more.  The error is that of the verdict: of the fringes and of the
    poses together.  The time is that of all threads, which other work on the machine hardly changes.
    """
    ours = [row for row in work if row["setting"]["estimator"] == "ours" and row["right"] == row["films"]]
    return min(ours, key=lambda row: both_rad(row) * row["cpu_ms"]) if ours else None


def both_rad(row: dict[str, Any]) -> float:
    """Error of measured and predicted phase together, infinite where either is not known."""
    known = row["phase_rad"] is not None and row["pose_rad"] is not None
    return math.hypot(row["phase_rad"], row["pose_rad"]) if known else math.inf


COLUMNS = {"setting": "name <36", "fringes": "phase_rad >8.4f", "poses": "pose_rad >8.4f", "gain": "gain_error >8.4f"}
COLUMNS |= {"right": "of >7", "CPU ms": "cpu_ms >8.2f", "CPU spread": "cpu_ms_spread >11.2f"}
COLUMNS |= {"CPU decodings": "cpu_ms_to_decoding >14.2f", "ms": ">7.1f", "spread": "ms_spread >7.1f"}
COLUMNS |= {"decodings": "ms_to_decoding >10.2f", "": "mark <14"}
COLUMNS |= {"motion": "extreme <38", "expected": "<22"}
COLUMNS |= {"came out": "outcome <13", "verdict": "<13", "rad": "true_excitation_rad >5.2f"}
COLUMNS |= {"gain ratio": "gain_ratio >10.3f", "sd": "gain_sd >6.3f", "tracked": ">8", "frames": ">7", "why": "<1"}


def work_of(rows: list[Row]) -> list[Row]:
    """A row for each setting, over all films."""
    films = [row for row in rows if "setting" in row]
    named = {setting_name(row["setting"]): EstimatorSetting(**row["setting"]) for row in films}
    return [_summary(setting, films) for setting in named.values()]


def table(rows: list[Row]) -> Iterator[Row]:
    """The settings, with the knee; then the extreme motions."""
    work = work_of(rows)
    knee = knee_of(work)
    for row in work:
        of = f"{row['right']}/{row['films']}"
        yield row | {"name": setting_name(row["setting"]), "of": of, "mark": _marks(row, knee)}
    yield from (row | {"outcome": row["outcome"].replace("wrong", "WRONG")} for row in rows if "extreme" in row)


def setting_name(setting: dict[str, Any]) -> str:
    """A setting in words."""
    if setting["estimator"] != "ours":
        return str(setting["estimator"])
    frames = {1: "every frame", 2: "every 2nd frame", 3: "every 3rd frame"}.get(setting["every"])
    share = {1.0: "", 0.75: ", 3/4 size", 0.5: ", 1/2 size"}.get(setting["scale"], ", 1/3 size")
    return f"{frames or 'every 4th frame'}{share}"


def knee_sentence(work: list[Row]) -> str:
    """Where the knee is, and how far the default is from it, in a sentence."""
    knee = knee_of(work)
    if knee is None:
        return "no setting judges all films right"
    default = next(row for row in work if row["default"])
    if knee["default"]:
        return "the default is at the knee: of the settings that judge all films right it has the least error x time"
    return (
        f"the knee is at {setting_name(knee['setting'])}: {both_rad(knee):.4f} rad in {knee['cpu_ms']:.2f} CPU ms; the "
        f"default has {both_rad(default):.4f} rad in {default['cpu_ms']:.2f} CPU ms a frame of the film"
    )


def plot(rows: list[Row]) -> Any:
    """CPU milliseconds a frame against the errors of phase, of gain, and of the verdict."""
    work = work_of(rows)
    sizes = {1.0: "full size", 0.75: "3/4 size", 0.5: "1/2 size"}

    def series(setting: dict[str, Any]) -> str:
        return sizes.get(setting["scale"], "1/3 size") if setting["estimator"] == "ours" else setting["estimator"]

    figure = error_against_time(
        grouped(({**row, "series": series(row["setting"])} for row in work), "series"),
        {
            "phase error of fringes and poses, rad (RMS)": lambda row: (
                both_rad(row) if row["pose_rad"] else row["phase_rad"]
            ),
            "error of the gain ratio (RMS)": lambda row: row["gain_error"],
            "share of verdicts that are not right": lambda row: 1 - row["right"] / row["films"],
        },
        lambda row: row["cpu_ms"],
        "CPU milliseconds a frame of the film",
        {"the default": next((row for row in work if row["default"]), None), "the knee": knee_of(work)},
    )
    figure.axes[-1].set_xscale("linear")
    figure.suptitle(knee_sentence(work), fontsize=9)
    return figure


def _marks(row: dict[str, Any], knee: dict[str, Any] | None) -> str:
    at_knee = knee is not None and row["setting"] == knee["setting"]
    return " ".join(word for word, holds in (("default", row["default"]), ("knee", at_knee)) if holds)


BENCH = Bench(rows, COLUMNS, lambda rows: [knee_sentence(work_of(rows))], table=table, plot=plot)
