"""The identity suite, with its table: is the whole identity read, and is a copy recognised?

Each clip has another payload, another build within the stated tolerances and another motion: 8 s of swaying,
H.264 crf 28.  The clips are few enough for a morning; confidence intervals show how far the rates can be trusted.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.asbuilt import as_built_from_json
from moireid.designer import Order, design_badge
from moireid.verifier.identity.compare_built import compare_built
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped
from moireid_lab.bench.identity.clips import Clip, read_clip
from moireid_lab.bench.identity.matching import matching_figures
from moireid_lab.evaluation.statistics import interval

CONDITIONS = ((64, 1000.0), (64, 2000.0), (64, 3000.0), (128, 2000.0), (128, 3000.0))
#: Films of a badge that is enrolled, of it again, and of a copy.
BUILT = ("enrolled", "original", "copy")
CLIPS, QUICK_CLIPS = 100, 4
BUILT_DISTANCE_MM = 1000.0


def rows(wish: Wish) -> Iterator[Row]:
    """A row for each clip, with the kind of its film; then the rates of false matches, made of them."""
    count = len(wish.seeds(CLIPS, QUICK_CLIPS))
    jobs = clips_of(count, wish.seed)
    found = []
    for row in wish.each(read_kind, {f"{kind} {number}": (kind, clip) for number, (kind, clip) in enumerate(jobs)}):
        found.append(row)
        yield row
    # The rates are fitted on one half of the clips and tested on the other.
    if wish.only is None and count > 1:
        yield {"matching": matching_figures(by_condition(found), quick=wish.quick, seed=wish.seed)}


def read_kind(job: tuple[str, Clip]) -> Row:
    """One clip, read."""
    return {"kind": job[0]} | read_clip(job[1])


def by_condition(rows: list[Row]) -> dict[str, list[Row]]:
    """The clips of each condition."""
    return grouped([row for row in rows if "matching" not in row and row["kind"] not in BUILT], "kind")


def clips_of(count: int, seed: int) -> list[tuple[str, Clip]]:
    """All clips with the name of their condition, the first of every condition first; each has its own seed."""
    jobs: list[tuple[str, Clip]] = []
    for k in range(count):
        for place, (bits, distance) in enumerate(CONDITIONS):
            rng = np.random.default_rng([seed, place, k])
            payload, (build, motion) = rng.bytes(bits // 8), rng.integers(0, 2**31, 2).tolist()
            clip = Clip(payload, distance, build, motion)
            jobs.append((f"{bits} bits, {distance / 1000:g} m", clip))
        rng = np.random.default_rng([seed, len(CONDITIONS), k])
        payload, of_badge = rng.bytes(8), rng.integers(0, 2**31, 6).tolist()
        for kind, motion, assembly in zip(BUILT, (1, 2, 3), (None, None, of_badge[4]), strict=True):
            jobs.append((kind, Clip(payload, BUILT_DISTANCE_MM, of_badge[0], of_badge[motion], assembly)))
    return jobs


def _condition(name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """One row of the table: rates with their 95 % intervals, phase error, beat error."""
    errors = np.array([e for row in rows for e in row["phase_error_rad"]])
    sds = np.array([s for row in rows for s in row["phase_sd_rad"]])
    # A film in which the badge was not found has no figures, and is counted as not read.
    beats = _known(rows, "beat_error")
    read = sum(row["read"] for row in rows)
    return {
        "name": name,
        "bits": name.split()[0],
        "m": float(name.split()[2]),
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


def built_counts(rows: list[Row]) -> dict[str, dict[str, int]]:
    """How often the figures of the original and of a copy agree and differ, at `BUILT_DISTANCE_MM`."""
    by_kind = grouped([row for row in rows if "matching" not in row and row["kind"] in BUILT], "kind")
    counts = {kind: dict.fromkeys(("agrees", "differs", "not_known"), 0) for kind in BUILT[1:]}
    for k, row in enumerate(by_kind.get(BUILT[0], [])):
        if row["as_built"] is None:
            continue
        badge = design_badge(Order("Bench", lens="50lpi", range_m=(0.8, 2.5)), bytes.fromhex(row["payload"]))
        enrolled = as_built_from_json(row["as_built"])
        for kind, count in counts.items():
            if by_kind[kind][k]["as_built"] is not None:
                found = as_built_from_json(by_kind[kind][k]["as_built"])
                count[compare_built(found, enrolled, badge).built] += 1
    return counts


COLUMNS = {
    "clips": "name <18",
    "read": "of >9",
    "wrong": "wrong_payloads >7",
    "accepted": ">10",
}
COLUMNS |= {"cell errors": "wrong_cells >13.5f", "phase rms": "phase_rms_rad >12.4f"}
COLUMNS |= {"beat error": "beat_error_worst >12.5f", "decode s": "identity_s >12.3f"}


def table(rows: list[Row]) -> Iterator[Row]:
    """A row for each condition."""
    for name, found in by_condition(rows).items():
        row = _condition(name, found)
        yield row | {"of": f"{row['read']}/{len(found)}"}


def notes(rows: list[Row]) -> Iterator[str]:
    """Original and copy, and the rates in sentences."""
    for kind, counts in built_counts(rows).items():
        judged = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())
        yield f"films of the {kind:<9} judged as: {judged}"
    for row in rows:
        yield from _matching_lines(row["matching"]) if "matching" in row else ()


def _matching_lines(matching: dict[str, Any]) -> list[str]:
    """The rates in sentences."""
    acquired, model = matching["failure_to_acquire"], matching["model"]
    tails = ", ".join(f"{100 * tail['other_films']:.2f} % for {100 * tail['model']:g} %" for tail in model["tails"])
    lines = [
        f"failure to acquire: {acquired['failed']} of {acquired['films']} films "
        f"(at most {acquired['interval'][1]:.4f})",
        f"error model: Student's t of {model['freedom']:.1f} degrees, scale {model['scale_rad']:.4f} rad; beyond its "
        f"tails lie of other films: {tails}",
    ]
    lines += [
        f"phase errors x {row['factor']:<4g}{row['source']:<13} FNMR {row['fnmr']:.4f} (at most "
        f"{row['fnmr_interval'][1]:.4f}), FMR {row['fmr']:.1e} (at most {row['fmr_interval'][1]:.1e}) over "
        f"{row['comparisons']:,} comparisons"
        for row in matching["decoding"]
    ]
    return lines


BENCH = Bench(rows, COLUMNS, notes, table=table, plot=("m", "phase_rms_rad", "bits"))
