"""Does each headline name what the forger did?  Run `moireid lab bench headlines [--quick] [--keep DIR]`.

Every forgery of `simulate --forge`, and a true film, on three motions, at two distances, with two seeds: 5 s at 30
frames a second, 720p.  A headline is misleading if it names a cause that is not among those that are true of the kind
(`CAUSES`), whatever the verdict.  With `--keep` the signals of each film are kept, and judged again without filming.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from moireid.designer import Request, design_badge, payload_from_hex
from moireid.errors import SpecError
from moireid.simulate.cameras import camera_named
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Claim, Report, verify
from moireid.verifier.decision.judge import judge_signals
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal
from moireid.verifier.fringes.phase_coverage import SeenWay
from moireid.verifier.identity.cell_slip import RowsApart
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.report.circumstances import Circumstances
from moireid.verifier.report.headline import headline_of
from moireid_lab.bench.bench_frame import Bench, Row, Wish, temporary_film

FRAMES, FPS, SEEDS = 150, 30.0, 2
MOTIONS, DISTANCES_M = ("sway", "linear", "handheld"), (0.6, 1.0)
#: Keys of a report that a headline needs, apart from what the motion test finds.
KEPT = ("claim_source", "badge", "identity", "frames", "cover", "camera")


def cases() -> dict[str, tuple[str, str, float, int]]:
    """Kind, motion, distance in metres and seed of each film, by its name."""
    return {
        f"{kind}_{motion}_{distance}_{seed}": (kind, motion, distance, seed)
        for seed in range(SEEDS)
        for distance in DISTANCES_M
        for motion in MOTIONS
        for kind in ("true", *KINDS)
    }


def reported(case: tuple[str, str, float, int]) -> Report:
    """Film and verify one case.  Raises: SpecError where it cannot be forged."""
    kind, motion, distance, seed = case
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    phone = camera_named("phone")
    camera = replace(phone, width=1280, height=720, focal_px=phone.focal_px * 2 / 3)
    scene = Scene(badge, Build.typical(seed), camera)
    course = motion_named(motion, distance_mm=1000 * distance, seed=seed)
    forge = None if kind == "true" else kind
    with temporary_film(scene, course, frames=FRAMES, fps=FPS, seed=seed, forge=forge) as video:
        return verify(video, Claim(badge, badge.id))


def stored(report: Report) -> bytes:
    """What a report is judged by again, in single precision."""
    document = report.to_json()
    found: dict[str, Any] = {name: document[name] for name in KEPT}
    own = report.invariant.reasons
    found["others"] = [reason.to_json() for reason in report.reasons if reason not in own]
    found["apart"] = list(vars(report.identity.rows_apart).values())
    arrays: dict[str, Any] = {}
    gratings = report.measurement.gratings if report.measurement else ()
    found["signals"] = [_parted(signal, f"{number}.", arrays) for number, signal in enumerate(gratings)]
    out = io.BytesIO()
    np.savez_compressed(out, document=np.array(json.dumps(found)), **arrays)
    return out.getvalue()


def _parted(signal: GratingSignal, prefix: str, arrays: dict[str, Any]) -> dict[str, Any]:
    """The numbers of a signal; its arrays go to `arrays`, without those that are only for photographs."""
    numbers: dict[str, Any] = {}
    values = {field.name: getattr(signal, field.name) for field in fields(signal)}
    way, beyond = values.pop("way"), values.pop("beyond")
    numbers["way"] = [way.whole, way.unseen]
    values |= {"law_rad": beyond.law_rad, "place_px": beyond.place_px}
    for name, value in values.items():
        if isinstance(value, np.ndarray):
            arrays[prefix + name] = value.astype(np.uint8 if name == "stretch" else np.float32)
        elif value is not None:
            numbers[name] = bool(value) if isinstance(value, np.bool_) else value
    return numbers


def restored(kept: bytes) -> tuple[dict[str, Any], list[GratingSignal], RowsApart]:
    """The rest of the report, the signals, and how the rows of the code moved."""
    arrays = np.load(io.BytesIO(kept))
    document = json.loads(str(arrays["document"]))
    signals = []
    for number, numbers in enumerate(document.pop("signals")):
        prefix = f"{number}."
        own = {name.removeprefix(prefix): arrays[name] for name in arrays.files if name.startswith(prefix)}
        own = {name: one.astype(np.int64 if name == "stretch" else float) for name, one in own.items()}
        none = np.zeros(len(own["times_s"]))
        depth, flat = DepthLaw(none, none, none), none.astype(complex)
        beyond = BeyondPhase(own.pop("law_rad"), depth, flat, own.pop("place_px"), flat + 1.0)
        numbers["way"] = SeenWay(*numbers["way"])
        signals.append(GratingSignal(**own, **numbers, beyond=beyond))
    return document, signals, RowsApart(*document.pop("apart"))


def judged(kept: bytes) -> dict[str, Any]:
    """The report of kept signals, as far as a headline needs it; without findings on photographs."""
    document, signals, apart = restored(kept)
    others = [Reason(**one) for one in document.pop("others")]
    motion = judge_signals(signals, code_apart=apart)
    moved = [reason for reason in motion.reasons if reason.code not in ON_PHOTOGRAPHS]
    reasons = [*moved, *others]
    return document | {
        "verdict": worst(reasons),
        "reasons": [reason.to_json() for reason in reasons],
        "invariant": motion.to_json() | {"verdict": worst(moved)},
        "explanations": [one.to_json() for one in motion.explanations],
    }


#: What the kept signals do not show.
ON_PHOTOGRAPHS = ("spacing", "cross_fade", "waveform", "third_harmonic", "photographs")
#: The cause that a headline names, by words of it, of today and of before.
NAMED = {
    "still": "stay still|hardly move|still picture",
    "other way": "other way",
    "less far": "only 0.[0-9]+ times as far|half as far",
    "farther": "move ([1-9][0-9.]* times|twice) as far",
    "drift": "drift at",
    "late": "come (late|early|[0-9.]+ s (late|early))",
    "place": "badge's place",
    "own motion": "by themselves|do not go with",
    "parts": "move apart|row to row|place to place",
    "spell": "(leave the law|leave it) (from|for a while)",
    "differ": "differ from the law|leave it, as|leave the law, perhaps|wander on top",
    "genuine": "^Genuine",
    "another badge": "^Another|^Several|two badges|but another|A copy",
    "film": "frames are mixed|zoomed|covers the badge|looks stretched",
}
#: What each forgery does, and so what a headline may name.  `differ` says by how much and when, and blames nothing; it
#: is too little where the gain alone is false, or the fringes rest.
CAUSES = {
    "true": ("genuine",),
    "frozen": ("still",),
    "photo": ("still",),
    "drift": ("drift", "differ"),
    "randomwalk": ("own motion", "differ", "spell"),
    "late": ("late", "differ"),
    "gain_low": ("less far",),
    "gain_high": ("farther",),
    "reversed": ("other way",),
    "splice": ("own motion", "differ", "spell"),
    "wobble": ("own motion", "differ", "spell"),
    "patchy": ("parts", "differ"),
    "generative": ("parts", "own motion", "differ"),
    "screen": ("own motion", "differ", "spell"),
}


def cause_named(title: str) -> str | None:
    """The cause that a headline names; None where it names none, as of a film that shows too little."""
    if title.endswith("would look the same"):
        return None
    return next((cause for cause, words in NAMED.items() if re.search(words, title)), None)


def is_right(kind: str, verdict: str, title: str) -> bool:
    """Whether the headline misleads no one about this kind; one that rejects must name a cause."""
    cause = cause_named(title)
    return cause in CAUSES[kind] or (cause is None and verdict == "inconclusive")


def row_of(case: tuple[str, str, float, int], document: Mapping[str, Any]) -> Row:
    """One film of the table."""
    kind, motion, distance, seed = case
    title = headline_of(document, Circumstances(datetime.now(UTC))).title
    right = is_right(kind, document["verdict"], title)
    return {
        "kind": kind,
        "motion": motion,
        "distance": distance,
        "seed": seed,
        "gain": document["invariant"]["gain_ratio"],
        "verdict": document["verdict"],
        "judged": "right" if right else "MISLEADING",
        "headline": title,
    }


def made(job: tuple[str, tuple[str, str, float, int], str | None]) -> Row:
    """Film one case, or take its signals from the folder, and judge it."""
    name, case, folder = job
    path = Path(folder) / f"{name}.npz" if folder else None
    if path is not None and path.exists():
        kept = path.read_bytes()
    else:
        try:
            kept = stored(reported(case))
        except SpecError:
            # Such as a drift on a motion that is steady.
            kept = b""
        if path is not None:
            path.write_bytes(kept)
    names = ("kind", "motion", "distance", "seed")
    if not kept:
        return dict(zip(names, case, strict=True)) | {"judged": "right", "verdict": "not made", "headline": "-"}
    return row_of(case, judged(kept))


def rows(wish: Wish) -> Iterator[Row]:
    """One row for each film; in a quick run those of the first motion, distance and seed."""
    jobs = {
        name: (name, case, str(wish.folder) if wish.folder else None)
        for name, case in cases().items()
        if not wish.quick or case[1:] == (MOTIONS[0], DISTANCES_M[0], 0)
    }
    if wish.folder is not None:
        wish.folder.mkdir(parents=True, exist_ok=True)
    yield from wish.each(made, jobs)


def notes(found: list[Row]) -> Iterator[str]:
    """How many headlines mislead."""
    wrong = [row for row in found if row["judged"] != "right"]
    yield f"{len(wrong)} of {len(found)} headlines mislead"


BENCH = Bench(
    rows,
    {
        "kind": "<11",
        "motion": "<9",
        "distance": ">8.1f",
        "seed": ">4d",
        "gain": ">7.3f",
        "verdict": "<12",
        "judged": "<11",
        "headline": "<0",
    },
    notes,
)
