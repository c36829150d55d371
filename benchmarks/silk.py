"""Silk and cells, read from afar: run `.venv/bin/python benchmarks/silk.py [--only REGEX] [--clips N]`.

Films of our own simulator as those of `moireid bench identity`: 8 s of swaying, 1080p, rolling shutter, noise,
H.264 crf 28, print scale, lens pitch and twist anywhere within the tolerances; both patterns have the same payloads,
builds and motions.  Printed are, by bits, distance and pattern: in how many films the whole identity is read, and a
wrong one; verdicts; cells read wrongly, of 100; error of a cell's phase, root mean square, and its error bar, rad;
seconds that reading takes, and what the films that were not accepted were found to lack.  Then error against time: the
same films as if they had ended earlier.  Then all formats, 64 bits, 5 s, from distances over their range.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from moireid.designer.formats import FORMATS
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped, run_script
from moireid_lab.bench.identity.clips import Clip, read_clip, request_of

PATTERNS, DISTANCES_M, CLIPS = ("cells", "silk"), (1.0, 2.0, 2.5, 3.0), 4
BITS = (64, 128)
#: Films of a format are from distances spread evenly over its range, but for the nearest part, where a swaying badge
#: leaves the picture; and as long as that.
NEAREST_SHARE, FORMAT_FRAMES = 0.25, 150
#: Parts of a range one after another are so far apart: the golden section fills it evenly, however many there are.
GOLDEN = (5**0.5 - 1) / 2


def filmed(job: tuple[str, Clip]) -> Row:
    """One film, read."""
    kind, clip = job
    return {"kind": kind} | read_clip(clip)


def in_formats(clips: int) -> dict[str, tuple[str, Clip]]:
    """The films of all formats, whose identities have 64 bits."""
    jobs = {}
    for number, name, pattern in itertools.product(range(clips), FORMATS, PATTERNS):
        payload = np.random.default_rng([64, number]).bytes(8)
        clip = Clip(payload, 0.0, number, number, pattern=pattern, format=name, frames=FORMAT_FRAMES)
        near, far = request_of(clip).range_m
        share = NEAREST_SHARE + (1 - NEAREST_SHARE) * (number * GOLDEN % 1)
        kind = f"{name}, {pattern}"
        jobs[f"{kind}: {number}"] = kind, replace(clip, distance_mm=1000 * (near + share * (far - near)))
    return jobs


def rows(wish: Wish) -> Iterator[Row]:
    """One row for each pattern, distance and payload size; and one for each length."""
    jobs = {}
    for bits in BITS[: 1 if wish.quick else None]:
        for distance in DISTANCES_M:
            for pattern in PATTERNS:
                for number in range(1 if wish.quick else wish.clips or CLIPS):
                    payload = np.random.default_rng([bits, number]).bytes(bits // 8)
                    clip = Clip(payload, 1000 * distance, number, number, shorter=distance == 2, pattern=pattern)
                    kind = f"{bits} bits, {distance:g} m, {pattern}"
                    jobs[f"{kind}: {number}"] = (kind, clip)
    found = list(wish.each(filmed, jobs | (in_formats(wish.clips or CLIPS) if not wish.quick else {})))
    for kind, own in grouped(found, "kind").items():
        errors, bars = (np.concatenate([row[name] for row in own]) for name in ("phase_error_rad", "phase_sd_rad"))
        yield {
            "films": kind,
            "count": len(own),
            "read": sum(row["read"] for row in own),
            "wrong": sum(row["wrong"] for row in own),
            "verdicts": _counted(row["verdict"] for row in own),
            "wrong cells, %": 100 * sum(row["cells_wrong"] for row in own) / max(len(errors), 1),
            "error rad": float(np.sqrt(np.mean(np.square(errors)))) if len(errors) else None,
            "error bar": float(np.sqrt(np.mean(np.square(bars)))) if len(bars) else None,
            "reading s": float(np.median([row["identity_s"] or 0.0 for row in own])),
            "lacking": _counted(code for row in own for code in row["findings"]),
        }
    for kind, own in grouped([row for row in found if row["shorter"]], "kind").items():
        for cuts in zip(*(row["shorter"] for row in own), strict=True):
            yield {
                "shorter films": f"{kind}, {cuts[0]['frames'] / 30:.1f} s",
                "read": sum(bool(one["soft"]) for one in cuts),
                "wrong cells, %": 100 * float(np.mean([one["cells_wrong"] for one in cuts])),
                "reading s": float(np.median([one["identity_s"] for one in cuts])),
            }


def _counted(words: Iterable[str]) -> str:
    return ", ".join(f"{word} {n}" for word, n in Counter(words).items())


COLUMNS = {"films": "<28", "shorter films": "<32", "count": ">5", "read": ">4", "wrong": ">5", "verdicts": "<28"}
COLUMNS |= {
    "wrong cells, %": ">14.1f",
    "error rad": ">9.3f",
    "error bar": ">9.3f",
    "reading s": ">9.2f",
    "lacking": "<10",
}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
