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

import contextlib
import math
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from moireid.result_cache import keep_row, kept_rows, program_digest
from moireid.verifier.camera.self_calibration import FilmWide
from moireid.verifier.fringes import signals as measure
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.session.claim import Claim
from moireid_lab.baseline.pipeline import PublishedReader, judge
from moireid_lab.bench.bench_rows import Where
from moireid_lab.bench.verify.films import KINDS, DecodedFilm, Kind, phase_error_rad, shoot
from moireid_lab.bench.verify.judged import judge_frames
from moireid_lab.bench.verify.motion_extremes import chosen, run_extremes

#: 8 s, so that every fourth frame is still more than the verifier asks for at least.
FRAMES, QUICK_FRAMES = 250, 150
RUNS, QUICK_RUNS = 3, 2
EVERY, SCALES = (1, 2, 3, 4), (1.0, 3 / 4, 1 / 2, 1 / 3)
ESTIMATORS = ("ours", "focal length given", "nothing solved", "poses not smoothed", "published")
QUICK_KINDS = (KINDS[1], KINDS[-1])
#: Packages that a row depends on; the digest of the rest of the package changes no figure.
ROOMS = ("bench", "designer", "idcodes", "simulate", "verifier")


@dataclass(frozen=True)
class EstimatorSetting:
    """Which frames are used, at which share of the film's resolution, and by which estimator; default: ours.

    focal length given: by the user.  nothing solved: a usual phone's focal length and shutter are assumed.
    published: `evaluation.baseline.published`.
    """

    every: int = 1
    scale: float = 1.0
    estimator: str = "ours"


DEFAULT = EstimatorSetting()
HERE = Where()


def settings(*, quick: bool) -> list[EstimatorSetting]:
    """All settings: every number of frames at every resolution by our estimator, and the others as films come."""
    others = [EstimatorSetting(estimator=name) for name in ESTIMATORS[1:]]
    if quick:
        return [DEFAULT, EstimatorSetting(2), EstimatorSetting(4), EstimatorSetting(1, 1 / 2), others[0], others[-1]]
    return [EstimatorSetting(every, scale) for scale in SCALES for every in EVERY] + others


def run(
    *, quick: bool, seed: int, kept: Path | None, where: Where = HERE, progress: Callable[[int, int | None], None]
) -> dict[str, Any]:
    """All figures as one JSON object; kept: a file that rows are added to, and not measured again.

    where: extremes are filmed and judged there.  What is timed runs by itself, here.
    """
    rows = kept_rows(kept)
    kinds = QUICK_KINDS if quick else KINDS
    total, done = len(kinds) + len(chosen(quick=quick)), 0

    def step() -> None:
        nonlocal done
        done += 1
        progress(done, total)

    films = []
    for kind in kinds:
        films += sweep(kind, quick=quick, seed=seed, kept=kept, rows=rows)
        step()
    work = [_summary(setting, films) for setting in settings(quick=quick)]
    return {
        "suite": "verify",
        "seed": seed,
        "versions": {name: version(name) for name in ("numpy", "scipy", "av")} | {"opencv": cv2.__version__},
        "films": films,
        "work": work,
        "knee": knee_of(work),
        "extremes": run_extremes(
            quick=quick, seed=seed, program=program_digest(*ROOMS), kept=kept, where=where, step=step
        ),
    }


def sweep(
    kind: Kind, *, quick: bool, seed: int, kept: Path | None, rows: dict[str, dict[str, Any]]
) -> list[dict[str, Any]]:
    """One film by all settings; it is filmed only where a row is missing.

    Forged films are judged once, because only the times of true films are used.
    """
    frames, runs = (QUICK_FRAMES, QUICK_RUNS) if quick else (FRAMES, RUNS)
    runs = 1 if kind.forge else runs
    keys = {
        setting: f"{program_digest(*ROOMS)} {kind} {frames} {runs} {seed} {setting}"
        for setting in settings(quick=quick)
    }
    if any(key not in rows for key in keys.values()):
        with tempfile.TemporaryDirectory() as folder:
            filmed = shoot(kind, frames, seed, Path(folder))
        timed(filmed, DEFAULT, 1)  # Tables that a process makes once are made here, and not while a setting is timed.
        for setting, key in keys.items():
            if key not in rows:
                rows[key] = timed(filmed, setting, runs)
                keep_row(kept, key, rows[key])
    return [rows[key] for key in keys.values()]


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
    focal_px = filmed.focal_px * setting.scale if setting.estimator == "focal length given" else None
    with _instead(setting.estimator):
        found = judge_frames(used_frames(filmed.frames, setting), Claim(badge, badge.id, focal_px))
    row = {
        "verdict": found.verdict,
        "against": [reason.code for reason in found.why],
        "tracked": found.tracked,
        "phase_rad": None,
        "pose_rad": None,
        "gain_error": None,
    }
    measurement = found.chapters[0].measurement
    if measurement is None:
        return row
    signal = measurement.gratings[0]
    used = np.isfinite(signal.phase_sd_rad)
    times, gain = measurement.times_s[used], found.invariant.gain_ratio
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


@contextlib.contextmanager
def _instead(estimator: str) -> Iterator[None]:
    """Replace a step of the verifier for a while; it has no option for this, because no user should choose it."""
    patches: list[tuple[Any, str, Any]] = []
    if estimator == "poses not smoothed":
        patches = [(measure, "smooth_camera", lambda camera_mm, *_: camera_mm)]
    elif estimator == "nothing solved":
        patches = [(FilmWide, "solve", lambda film: None)]
    before = [getattr(owner, name) for owner, name, _ in patches]
    for owner, name, other in patches:
        setattr(owner, name, other)
    try:
        yield
    finally:
        for (owner, name, _), own in zip(patches, before, strict=True):
            setattr(owner, name, own)


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


#: Colours of the working resolutions, and marks of the frames used.
COLOURS = {1.0: "#12406b", 0.75: "#1f6fb2", 0.5: "#3fa7a0", 1 / 3: "#c9a227"}
MARKS = {1: "o", 2: "s", 3: "^", 4: "D"}
OTHERS = {
    "focal length given": "#2e7d4f",
    "nothing solved": "#8a5aa8",
    "poses not smoothed": "#c2571a",
    "published": "#7a1f1f",
}


def verify_table(result: dict[str, Any]) -> str:
    """The verify suite as text."""
    lines = [
        f"{'setting':<36}{'fringes':>9}{'poses':>9}{'gain':>8}{'right':>8}{'CPU ms':>9}{'spread':>8}{'decodings':>11}"
        f"{'ms':>8}{'spread':>8}{'decodings':>11}"
    ]
    knee = result["knee"]
    for row in result["work"]:
        lines.append(
            f"{setting_name(row['setting']):<36}{_figure(row['phase_rad'], 4):>9}{_figure(row['pose_rad'], 4):>9}"
            f"{_figure(row['gain_error'], 4):>8}{row['right']:>6}/{row['films']}{row['cpu_ms']:>9.2f}"
            f"{row['cpu_ms_spread']:>8.2f}{row['cpu_ms_to_decoding']:>11.2f}{row['ms']:>8.1f}{row['ms_spread']:>8.1f}"
            f"{row['ms_to_decoding']:>11.2f}{_marks(row, knee)}"
        )
    lines += ["", knee_sentence(result), ""]
    lines.append(f"{'motion':<38}{'expected':<15}{'came out':<14}{'':<7}{'rad':>6}{'gain':>17}{'tracked':>11}  why")
    for row in result["extremes"]:
        outcome = "WRONG" if row["outcome"] == "wrong" else row["outcome"]
        gain = "-" if row["gain_ratio"] is None else f"{row['gain_ratio']:.3f} ± {_figure(row['gain_sd'], 3)}"
        lines.append(
            f"{row['name']:<38}{row['expected']:<15}{row['verdict'] or '-':<14}{outcome:<7}"
            f"{_figure(row['true_excitation_rad'], 2):>6}{gain:>17}{row['tracked']:>6}/{row['frames']:<4}  {row['why']}"
        )
    return "\n".join(lines)


def setting_name(setting: dict[str, Any]) -> str:
    """A setting in words."""
    if setting["estimator"] != "ours":
        return str(setting["estimator"])
    frames = {1: "every frame", 2: "every 2nd frame", 3: "every 3rd frame"}.get(setting["every"])
    share = {1.0: "", 0.75: ", 3/4 size", 0.5: ", 1/2 size"}.get(setting["scale"], ", 1/3 size")
    return f"{frames or 'every 4th frame'}{share}"


def knee_sentence(result: dict[str, Any]) -> str:
    """Where the knee is, and how far the default is from it, in a sentence."""
    knee = result["knee"]
    if knee is None:
        return "no setting judges all films right"
    default = next(row for row in result["work"] if row["default"])
    if knee["default"]:
        return "the default is at the knee: of the settings that judge all films right it has the least error x time"
    return (
        f"the knee is at {setting_name(knee['setting'])}: {both_rad(knee):.4f} rad in {knee['cpu_ms']:.2f} CPU ms; the "
        f"default has {both_rad(default):.4f} rad in {default['cpu_ms']:.2f} CPU ms a frame of the film"
    )


def verify_plot(result: dict[str, Any]) -> Any:
    """CPU milliseconds a frame against the errors of phase, of gain, and of the verdict."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(12, 4.6), layout="constrained")
    FigureCanvasSVG(figure)
    plots = figure.subplots(1, 3, sharey=True, width_ratios=(3, 3, 2))
    xs = {
        0: lambda row: both_rad(row) if row["pose_rad"] else row["phase_rad"],
        1: lambda row: row["gain_error"],
        2: lambda row: 100 * (1 - row["right"] / row["films"]),
    }
    for place, axes in enumerate(plots):
        _panel(axes, result, xs[place])
        axes.set_yscale("log")
        if place < 2:
            axes.set_xscale("log")
        for scale in (axes.xaxis, axes.yaxis)[0 if place < 2 else 1 :]:
            scale.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            scale.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            scale.set_minor_formatter(NullFormatter())
        axes.grid(color="#e4e8ed", which="both", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
    plots[0].set_ylabel("CPU milliseconds a frame of the film")
    plots[0].set_xlabel("phase error of fringes and poses, rad (RMS)")
    plots[1].set_xlabel("error of the gain ratio (RMS)")
    plots[2].set_xlabel("verdicts that are not right, %")
    figure.legend(*plots[0].get_legend_handles_labels(), loc="outside right center", frameon=False, fontsize=8)
    figure.suptitle(knee_sentence(result), fontsize=9)
    return figure


def _panel(axes: Any, result: dict[str, Any], error: Any) -> None:
    """All settings of one error; the default is starred, the knee ringed."""
    for scale, colour in COLOURS.items():
        own = [
            row for row in result["work"] if row["setting"]["estimator"] == "ours" and row["setting"]["scale"] == scale
        ]
        own = [row for row in own if error(row) is not None]
        if not own:
            continue
        axes.plot([error(row) for row in own], [row["cpu_ms"] for row in own], color=colour, linewidth=1, alpha=0.6)
        for row in own:
            # Films that a setting cannot read are missing in its errors, so settings with a wrong verdict are hollow.
            face = colour if row["right"] == row["films"] else "white"
            axes.plot(error(row), row["cpu_ms"], MARKS[row["setting"]["every"]], color=colour, mfc=face, markersize=6)
        name = {1.0: "full size", 0.75: "3/4 size", 0.5: "1/2 size"}.get(scale, "1/3 size")
        axes.plot([], [], "-", color=colour, linewidth=3, label=name)
    for every, mark in MARKS.items():
        words = {1: "every frame", 2: "every 2nd", 3: "every 3rd"}.get(every, "every 4th")
        axes.plot([], [], mark, color="#5a6673", markersize=6, label=words)
    axes.plot([], [], "o", color="#5a6673", mfc="white", markersize=6, label="hollow: a verdict is not right")
    for row in result["work"]:
        name = row["setting"]["estimator"]
        if name in OTHERS and error(row) is not None:
            axes.plot(error(row), row["cpu_ms"], "P", color=OTHERS[name], markersize=9)
        if name in OTHERS:
            axes.plot([], [], "P", color=OTHERS[name], markersize=9, label=name)
        if row["default"] and error(row) is not None:
            axes.plot(error(row), row["cpu_ms"], "*", color="#12406b", mec="white", markersize=17, zorder=5)
    axes.plot([], [], "*", color="#12406b", markersize=11, label="the default")
    knee = result["knee"]
    if knee is not None:
        axes.plot(error(knee), knee["cpu_ms"], "o", mfc="none", mec="#c0392b", mew=1.6, markersize=15, zorder=6)
        axes.plot([], [], "o", mfc="none", mec="#c0392b", mew=1.6, markersize=11, label="the knee")


def _marks(row: dict[str, Any], knee: dict[str, Any] | None) -> str:
    default = "  default" if row["default"] else ""
    return default + ("  knee" if knee is not None and row["setting"] == knee["setting"] else "")


def _figure(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
