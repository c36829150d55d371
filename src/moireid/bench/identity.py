"""Does the whole identity come back, and is a copy told from the original?

Each clip is another payload, another build within the stated tolerances, another motion: 8 s of swaying, H.264 crf 28.
Numbers of clips are small enough for a morning; intervals say what they can mean.
"""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from moireid.asbuilt import as_built_from_json
from moireid.bench.clips import Clip, one_thread, read_clip
from moireid.bench.matching import matching_figures
from moireid.bench.stats import interval
from moireid.designer import Request, design_badge
from moireid.verifier.built import compare_built

CONDITIONS = ((64, 1000.0), (64, 2000.0), (64, 3000.0), (128, 2000.0), (128, 3000.0))
CLIPS, QUICK_CLIPS = 100, 4
BUILT_DISTANCE_MM = 1000.0


def run(
    *, quick: bool, seed: int, clips: int | None = None, progress: Callable[[int, int | None], None]
) -> dict[str, Any]:
    """All figures of the suite as one JSON object."""
    count = clips or (QUICK_CLIPS if quick else CLIPS)
    rng = np.random.default_rng(seed)
    jobs: list[tuple[str, Clip]] = []
    for bits, distance in CONDITIONS:
        for _ in range(count):
            payload = rng.bytes(bits // 8)
            seeds = rng.integers(0, 2**31, 2)
            jobs.append((f"{bits} bits, {distance / 1000:g} m", Clip(payload, distance, int(seeds[0]), int(seeds[1]))))
    for _ in range(count):
        payload, of_badge = rng.bytes(8), [int(s) for s in rng.integers(0, 2**31, 6)]
        for kind, motion, assembly in (("enrolled", 1, None), ("original", 2, None), ("copy", 3, of_badge[4])):
            jobs.append((kind, Clip(payload, BUILT_DISTANCE_MM, of_badge[0], of_badge[motion], assembly)))
    rows = _read_all([clip for _, clip in jobs], progress)
    groups: dict[str, list[dict[str, Any]]] = {}
    for (name, _), row in zip(jobs, rows, strict=True):
        groups.setdefault(name, []).append(row)
    built = {name: groups.pop(name) for name in ("enrolled", "original", "copy")}
    conditions = [_condition(name, found) for name, found in groups.items()]
    payloads = [clip.payload for name, clip in jobs if name == "enrolled"]
    far = [e for row in groups["64 bits, 3 m"] for e in row["phase_error_rad"]]
    return {
        "suite": "identity", "seed": seed, "clips": count, "conditions": conditions,
        "built": _built(payloads, built), "matching": matching_figures(np.array(far), quick=quick, seed=seed),
    }  # fmt: skip


def _read_all(clips: list[Clip], progress: Callable[[int, int | None], None]) -> list[dict[str, Any]]:
    context = multiprocessing.get_context("spawn")
    rows = []
    with ProcessPoolExecutor(max_workers=2, mp_context=context, initializer=one_thread) as pool:
        for done, row in enumerate(pool.map(read_clip, clips), start=1):
            rows.append(row)
            progress(done, len(clips))
    return rows


def _condition(name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """One row of the table: rates with their 95 % intervals, phase error, beat error."""
    errors = np.array([e for row in rows for e in row["phase_error_rad"]])
    sds = np.array([s for row in rows for s in row["phase_sd_rad"]])
    beats = np.array([row["beat_error"] for row in rows if row["beat_error"] is not None])
    read = sum(row["read"] for row in rows)
    return {
        "name": name, "clips": len(rows), "read": read, "read_interval": interval(read, len(rows)),
        "wrong_payloads": sum(row["wrong"] for row in rows),
        "accepted": sum(row["verdict"] == "accept" for row in rows),
        "wrong_cells": float(np.mean(np.abs(errors) > math.pi / 4)),
        "phase_rms_rad": float(np.sqrt(np.mean(errors**2))),
        "phase_error_over_sd": float(np.sqrt(np.mean((errors / sds) ** 2))),
        "beat_error_worst": float(np.abs(beats).max()), "identity_s": float(np.median([r["identity_s"] for r in rows])),
        "correlation_median": float(np.median([r["correlation"] for r in rows])),
        "gain_rms_error": float(np.sqrt(np.mean([(r["gain"] - 1) ** 2 for r in rows]))),
    }  # fmt: skip


def _built(payloads: list[bytes], rows: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """How often the original and a copy were told as what they are, at `BUILT_DISTANCE_MM`."""
    counts = {kind: dict.fromkeys(("original", "copy", "not_known"), 0) for kind in ("original", "copy")}
    for k, payload in enumerate(payloads):
        badge = design_badge(Request("Bench", range_m=(0.8, 2.5)), payload)
        if rows["enrolled"][k]["as_built"] is None:
            continue
        enrolled = as_built_from_json(rows["enrolled"][k]["as_built"])
        for kind, count in counts.items():
            if rows[kind][k]["as_built"] is not None:
                found = as_built_from_json(rows[kind][k]["as_built"])
                count[compare_built(found, enrolled, badge).built] += 1
    return counts
