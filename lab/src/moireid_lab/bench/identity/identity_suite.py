"""The identity suite: is the whole identity read, is a copy recognised, and how often is another person matched?

Each clip has another payload, another build within the stated tolerances and another motion: 8 s of swaying,
H.264 crf 28.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from moireid.asbuilt import as_built_from_json
from moireid.designer import Order, design_badge
from moireid.verifier.identity.compare_built import compare_built
from moireid_lab.bench.identity.clips import Clip, read_clip
from moireid_lab.bench.identity.matching import matching_row
from moireid_lab.bench.part import INCONCLUSIVE, OWN, RIGHT, WRONG, Asked, Part, Row

CONDITIONS = ((64, 1000.0), (64, 2000.0), (64, 3000.0), (128, 2000.0), (128, 3000.0))
#: Films of a badge that is enrolled, of it again, and of a copy.
BUILT = ("enrolled", "original", "copy")
BUILT_DISTANCE_MM, MATCHING = 1000.0, "matching"


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


def judged(job: tuple[str, list[Clip]], folder: Path) -> Row:
    """One clip, read; three clips of one badge, compared; or the rates of false matches, by the errors of some."""
    kind, clips = job
    read = [read_clip(clip) for clip in clips]
    if kind == MATCHING:
        return matching_row([np.array(one["phase_error_rad"]) for one in read])
    first = read[0]
    if kind != "built":
        outcome = RIGHT if first["read"] else WRONG if first["wrong"] else INCONCLUSIVE
        errors = np.array(first["phase_error_rad"])
        row: Row = {"kind": kind, "answers": {"read": outcome}, "verdict": first["verdict"]}
        figures = {"phase_rms_rad": float(np.sqrt(np.mean(errors**2))) if len(errors) else math.nan}
        figures |= {"gain": first["gain"], "beat_error": first["beat_error"], "identity_s": first["identity_s"]}
        return row | {name: value for name, value in figures.items() if value is not None and value == value}
    row = {"kind": "enrolled from one film", "answers": dict.fromkeys(BUILT[1:], INCONCLUSIVE)}
    if first["as_built"] is not None:
        badge = design_badge(Order("Bench", lens="50lpi", range_m=(0.8, 2.5)), clips[0].payload)
        known = as_built_from_json(first["as_built"])
        for name, right, other in zip(BUILT[1:], ("agrees", "differs"), read[1:], strict=True):
            if other["as_built"] is not None:
                built = compare_built(as_built_from_json(other["as_built"]), known, badge).built
                row["answers"][name] = RIGHT if built == right else INCONCLUSIVE if built == "not_known" else WRONG
    return row


def cases(asked: Asked) -> dict[str, tuple[str, list[Clip]]]:
    """All clips, those of one badge together; and the rates, by the first four at 3 m."""
    found: dict[str, tuple[str, list[Clip]]] = {}
    for number, (kind, clip) in enumerate(clips_of(asked.clips or 8, 0)):
        name = "built" if kind in BUILT else kind
        found.setdefault(f"{name}|{number // (len(CONDITIONS) + len(BUILT))}", (name, []))[1].append(clip)
    far = [clips[0] for name, clips in found.values() if name == "64 bits, 3 m"]
    return found | {MATCHING: (MATCHING, far[:4])}


QUESTIONS = {
    "read": "Is the identity of 64 or 128 bits read whole, at 1 to 3 m?",
    "original": "Do the figures of a badge's second film agree with those of its first?",
    "copy": "Do those of a newly assembled copy differ?",
    "matching": "Is a reading drawn from the films' errors decoded as the right person, and as no other of 10,000?",
}
PART = Part(QUESTIONS, OWN, cases, judged, 2)
