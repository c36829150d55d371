"""The identity suite, with its table and plot: is the whole identity read, and is a copy recognised?

Error against run time of the identity stage comes from clips that are read as if they had ended earlier, by both
decoders.  Each clip has another payload, another build within the stated tolerances and another motion: 8 s of swaying,
H.264 crf 28.  The clips are few enough for a morning; confidence intervals show how far the rates can be trusted.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.asbuilt import as_built_from_json
from moireid.designer import Request, design_badge
from moireid.result_cache import program_digest
from moireid.verifier.identity.compare_built import compare_built
from moireid_lab.bench.bench_frame import Wish, text_table
from moireid_lab.bench.bench_plots import figure_of, plain
from moireid_lab.bench.identity.clips import CRF, FOCAL_PX, FPS, HEIGHT, WIDTH, Clip, read_clip
from moireid_lab.bench.identity.matching import matching_figures
from moireid_lab.evaluation.statistics import interval


def shorter_figures(groups: dict[str, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """One row for each condition and number of frames: cells wrong, payloads read and wrong, milliseconds.

    Convention: milliseconds are medians; `measure` is camera and fringes, `identity` the decoding.
    """
    found = []
    for name, rows in groups.items():
        by_length: dict[int, list[dict[str, Any]]] = {}
        for row in rows:
            for shorter in row["shorter"]:
                by_length.setdefault(shorter["frames"], []).append(shorter)
        # Few films lose frames; lengths that hardly any clip has are left out.
        for frames, some in sorted(by_length.items()):
            if len(some) * 2 < len([row for row in rows if row["shorter"]]):
                continue
            found.append(
                {
                    "name": name,
                    "frames": frames,
                    "clips": len(some),
                    "cells_wrong": float(np.mean([one["cells_wrong"] for one in some])),
                    "soft_read": float(np.mean([one["soft"] is True for one in some])),
                    "hard_read": float(np.mean([one["hard"] is True for one in some])),
                    "wrong_payloads": sum(one["soft"] is False or one["hard"] is False for one in some),
                    "measure_ms": 1e3 * float(np.median([one["measure_s"] for one in some])),
                    "identity_ms": 1e3 * float(np.median([one["identity_s"] for one in some])),
                }
            )
    return found


CONDITIONS = ((64, 1000.0), (64, 2000.0), (64, 3000.0), (128, 2000.0), (128, 3000.0))
CLIPS, QUICK_CLIPS = 100, 4
#: Clips of a condition that are also read shortened.
SHORTER_CLIPS = 20
BUILT_DISTANCE_MM = 1000.0


def run(wish: Wish) -> dict[str, Any]:
    """All figures of the suite as one JSON object."""
    count, seed = len(wish.seeds(CLIPS, QUICK_CLIPS)), wish.seed
    jobs = _jobs(count, seed)
    groups: dict[str, list[dict[str, Any]]] = {}
    for (name, _), row in zip(jobs, _read_all([clip for _, clip in jobs], wish), strict=True):
        groups.setdefault(name, []).append(row)
    built = {name: groups.pop(name) for name in ("enrolled", "original", "copy")}
    return {
        "suite": "identity",
        "seed": seed,
        "clips": count,
        "conditions": [_condition(name, found) for name, found in groups.items()],
        "shorter": shorter_figures(groups),
        "built": _built(built),
        "matching": matching_figures(groups, quick=wish.quick, seed=seed),
    }


def _jobs(count: int, seed: int) -> list[tuple[str, Clip]]:
    """All clips with the name of their condition, the first of every condition first; each has its own seed."""
    jobs: list[tuple[str, Clip]] = []
    for k in range(count):
        for place, (bits, distance) in enumerate(CONDITIONS):
            rng = np.random.default_rng([seed, place, k])
            payload, (build, motion) = rng.bytes(bits // 8), rng.integers(0, 2**31, 2).tolist()
            clip = Clip(payload, distance, build, motion, shorter=k < SHORTER_CLIPS)
            jobs.append((f"{bits} bits, {distance / 1000:g} m", clip))
        rng = np.random.default_rng([seed, len(CONDITIONS), k])
        payload, of_badge = rng.bytes(8), rng.integers(0, 2**31, 6).tolist()
        for kind, motion, assembly in (("enrolled", 1, None), ("original", 2, None), ("copy", 3, of_badge[4])):
            jobs.append((kind, Clip(payload, BUILT_DISTANCE_MM, of_badge[0], of_badge[motion], assembly)))
    return jobs


def _read_all(clips: list[Clip], wish: Wish) -> list[dict[str, Any]]:
    """One row a clip, in their order; those that are kept are not filmed again."""
    return list(wish.each(read_clip, {_key(clip): clip for clip in clips}))


def _key(clip: Clip) -> str:
    """The key of a clip: clip, camera, and a digest of the program; so changed code gives new rows."""
    return f"{program_digest()} {WIDTH}x{HEIGHT} {FOCAL_PX} {FPS} {CRF} {clip}"


def _condition(name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """One row of the table: rates with their 95 % intervals, phase error, beat error."""
    errors = np.array([e for row in rows for e in row["phase_error_rad"]])
    sds = np.array([s for row in rows for s in row["phase_sd_rad"]])
    # A film in which the badge was not found has no figures, and is counted as not read.
    beats = _known(rows, "beat_error")
    read = sum(row["read"] for row in rows)
    return {
        "name": name,
        "clips": len(rows),
        "read": read,
        "read_interval": interval(read, len(rows)),
        "wrong_payloads": sum(row["wrong"] for row in rows),
        "accepted": sum(row["verdict"] == "accept" for row in rows),
        "wrong_cells": sum(row["cells_wrong"] for row in rows) / max(len(errors), 1),
        "phase_median_rad": _middle(np.abs(errors)),
        "phase_rms_rad": _rms(errors),
        "cells_unclear": float(np.mean(sds > math.pi / 8)) if len(sds) else 1.0,
        "beat_error_worst": float(np.abs(beats).max(initial=0.0)),
        "identity_s": _middle(_known(rows, "identity_s")),
        "correlation_median": _middle(_known(rows, "correlation")),
        "gain_rms_error": _rms(_known(rows, "gain") - 1),
    }


def _known(rows: list[dict[str, Any]], name: str) -> NDArray[np.float64]:
    return np.array([row[name] for row in rows if row[name] is not None], float)


def _middle(values: NDArray[np.float64]) -> float:
    return float(np.median(values)) if len(values) else 0.0


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _built(rows: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """How often the figures of the original and of a copy agree and differ, at `BUILT_DISTANCE_MM`."""
    counts = {kind: dict.fromkeys(("agrees", "differs", "not_known"), 0) for kind in ("original", "copy")}
    for k, row in enumerate(rows["enrolled"]):
        if row["as_built"] is None:
            continue
        badge = design_badge(Request("Bench", range_m=(0.8, 2.5)), bytes.fromhex(row["payload"]))
        enrolled = as_built_from_json(row["as_built"])
        for kind, count in counts.items():
            if rows[kind][k]["as_built"] is not None:
                found = as_built_from_json(rows[kind][k]["as_built"])
                count[compare_built(found, enrolled, badge).built] += 1
    return counts


COLUMNS = {"clips": "name <18", "read": "of >9", "wrong": "wrong_payloads >7", "accepted": ">10"}
COLUMNS |= {"cell errors": "wrong_cells >13.5f", "phase rms": "phase_rms_rad >12.4f"}
COLUMNS |= {"beat error": "beat_error_worst >12.5f", "decode s": "identity_s >12.3f"}
SHORTER_COLUMNS = {"clips cut short": "name <18", "frames": ">7", "cell errors": "cells_wrong >13.5f"}
SHORTER_COLUMNS |= {"soft": "soft_read >7.2f", "hard": "hard_read >7.2f", "measure ms": "measure_ms >12.0f"}
SHORTER_COLUMNS |= {"decode ms": "identity_ms >12.0f"}


def identity_table(result: dict[str, Any]) -> str:
    """The identity suite as text."""
    conditions = [row | {"of": f"{row['read']}/{row['clips']}"} for row in result["conditions"]]
    built = [
        f"films of the {kind:<9} judged as: "
        + ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())
        for kind, counts in result["built"].items()
    ]
    shorter = text_table(result["shorter"], SHORTER_COLUMNS)
    return "\n".join(
        [text_table(conditions, COLUMNS), "", *built, "", *_matching_lines(result["matching"]), "", shorter]
    )


def _matching_lines(matching: dict[str, Any]) -> list[str]:
    """The rates in sentences."""
    acquired, scores, issued = matching["failure_to_acquire"], matching["scores"], matching["issued"]
    model, undetected = matching["model"], matching["undetected"]
    tails = ", ".join(f"{100 * tail['other_films']:.2f} % for {100 * tail['model']:g} %" for tail in model["tails"])
    lines = [
        f"failure to acquire: {acquired['failed']} of {acquired['films']} films "
        f"(at most {acquired['interval'][1]:.4f})",
        f"scores, threshold {scores['threshold']:.3f} fixed on the other half of the films: "
        f"FNMR {scores['fnmr']:.4f} (at most {scores['fnmr_interval'][1]:.4f}) of {scores['films']} films, "
        f"FMR {scores['fmr']:.1e} (at most {scores['fmr_interval'][1]:.1e}) of {scores['comparisons']:,} comparisons, "
        f"equal error rate {scores['equal_error_rate']:.1e}",
        f"least score of the same badge {scores['genuine_least']:.3f}, greatest of others "
        f"{scores['impostor_greatest']:.3f}",
        f"error model: Student's t of {model['freedom']:.1f} degrees, scale {model['scale_rad']:.4f} rad; beyond its "
        f"tails lie of other films: {tails}",
    ]
    lines += [
        f"phase errors x {row['factor']:<4g}{row['source']:<13} FNMR {row['fnmr']:.4f} (at most "
        f"{row['fnmr_interval'][1]:.4f}), FMR {row['fmr']:.1e} (at most {row['fmr_interval'][1]:.1e}) over "
        f"{row['comparisons']:,} comparisons"
        for row in matching["decoding"]
    ]
    lines += [
        f"{issued['payloads']:,} issued words differ in {issued['least_distance_bytes']} bytes or more; "
        f"the code promises {issued['promised_bytes']}",
        f"wrong payloads of {undetected['words_each']:,} words at random: {undetected['random']}; "
        f"of as many with one error more than can be corrected: {undetected['one_error_too_many']}",
    ]
    return lines


def identity_plot(result: dict[str, Any]) -> Any:
    """Scatter of the cells' phase against distance, with the point of confusion."""
    figure = figure_of(6, 3.6)
    axes = figure.add_subplot()
    for bits, colour in ((64, "#1f6fb2"), (128, "#c2571a")):
        rows = [row for row in result["conditions"] if row["name"].startswith(f"{bits} ")]
        metres = [float(row["name"].split(", ")[1].removesuffix(" m")) for row in rows]
        axes.semilogy(metres, [row["phase_rms_rad"] for row in rows], "o-", color=colour, label=f"{bits} bits")
    axes.axhline(3.14159 / 4, color="#8a97a6", linestyle=":", label="point of confusion")
    axes.set_xlabel("distance, m")
    axes.set_ylabel("phase error of a cell, rad (RMS)")
    axes.legend(frameon=False)
    plain(axes)
    return figure
