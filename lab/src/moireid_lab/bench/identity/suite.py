"""Is the whole identity read, and is a copy distinguished from the original?

Each clip has another payload, another build within the stated tolerances and another motion: 8 s of swaying, H.264
crf 28.  The clips are few enough for a morning; confidence intervals show how far the rates can be trusted.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.asbuilt import as_built_from_json
from moireid.designer import Request, design_badge
from moireid.result_cache import program_digest
from moireid.verifier.identity.compare_built import compare_built
from moireid_lab.bench.identity.clips import CRF, FOCAL_PX, FPS, HEIGHT, WIDTH, Clip, read_clip
from moireid_lab.bench.identity.matching import matching_figures
from moireid_lab.bench.identity.shorter import shorter_figures
from moireid_lab.bench.rows import Where, made_rows
from moireid_lab.evaluation.statistics import interval

CONDITIONS = ((64, 1000.0), (64, 2000.0), (64, 3000.0), (128, 2000.0), (128, 3000.0))
CLIPS, QUICK_CLIPS = 100, 4
#: Clips of a condition that are also read shortened.
SHORTER_CLIPS = 20
BUILT_DISTANCE_MM = 1000.0
HERE = Where()


def run(
    *,
    quick: bool,
    seed: int,
    clips: int | None = None,
    kept: Path | None = None,
    where: Where = HERE,
    progress: Callable[[int, int | None], None],
) -> dict[str, Any]:
    """All figures of the suite as one JSON object.

    Parameters: kept: a file that rows are added to as clips are read; those in it already are not filmed again.
    """
    count = clips or (QUICK_CLIPS if quick else CLIPS)
    jobs = _jobs(count, seed)
    rows = _read_all([clip for _, clip in jobs], kept, progress, where)
    groups: dict[str, list[dict[str, Any]]] = {}
    for (name, _), row in zip(jobs, rows, strict=True):
        groups.setdefault(name, []).append(row)
    built = {name: groups.pop(name) for name in ("enrolled", "original", "copy")}
    return {
        "suite": "identity",
        "seed": seed,
        "clips": count,
        "conditions": [_condition(name, found) for name, found in groups.items()],
        "shorter": shorter_figures(groups),
        "built": _built(built),
        "matching": matching_figures(groups, quick=quick, seed=seed),
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


def _read_all(
    clips: list[Clip], kept: Path | None, progress: Callable[[int, int | None], None], where: Where = HERE
) -> list[dict[str, Any]]:
    """One row a clip, in their order."""
    done = itertools.count(1)
    jobs = [(_key(clip), clip) for clip in clips]
    return made_rows(read_clip, jobs, kept=kept, where=where, step=lambda: progress(next(done), len(clips)))


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
