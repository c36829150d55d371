"""One clip of one badge, filmed and read, in a process of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

#: The picture is cropped to the room of a swaying badge at 1 m; pixels to the millimetre are those of 1080p.
WIDTH, HEIGHT, FOCAL_PX = 1024, 576, 1450.0
FPS, CRF = 30.0, 28


@dataclass(frozen=True)
class Clip:
    """What to film: payload, distance, how the badge is built, and the seeds of build and motion."""

    payload: bytes
    distance_mm: float
    build_seed: int
    motion_seed: int
    assembly_seed: int | None = None
    frames: int = 240


def build_of(clip: Clip) -> Any:
    """A build anywhere within the tolerances: print scale 0.5 %, lens pitch 0.3 %, twist 0.3 degrees, any offset.

    `assembly_seed` assembles the same print again: the sheet gets another offset and twist.
    """
    from moireid.simulate.scene import Build

    rng = np.random.default_rng(clip.build_seed)
    print_scale, lens_scale = 1 + rng.uniform(-0.005, 0.005), 1 + rng.uniform(-0.003, 0.003)
    if clip.assembly_seed is not None:
        rng = np.random.default_rng(clip.assembly_seed)
    return Build(
        lens_offset_mm=float(rng.uniform(-0.254, 0.254)),
        twist_rad=math.radians(float(rng.uniform(-0.3, 0.3))),
        print_scale=float(print_scale),
        lens_scale=float(lens_scale),
    )


def read_clip(clip: Clip) -> dict[str, Any]:
    """Film the clip, read it back, and compare with what was printed; one row of figures."""
    from moireid.designer import Order, design_badge
    from moireid.idcodes.spacing import true_phases_rad
    from moireid.question import KnownCamera, Question
    from moireid.simulate.motion import motion_named
    from moireid.simulate.scene import Camera, Scene
    from moireid.verifier.identity.compare_built import filmed_built
    from moireid.verifier.identity.decode import read_identity
    from moireid.verifier.session.film import verify
    from moireid_lab.bench.part import temporary_film

    badge = design_badge(Order("Bench", lens="50lpi", range_m=(0.8, 2.5)), clip.payload)
    build = build_of(clip)
    scene = Scene(badge, build, Camera(WIDTH, HEIGHT, FOCAL_PX))
    motion = motion_named("sway", distance_mm=clip.distance_mm, seed=clip.motion_seed)
    how = {"frames": clip.frames, "fps": FPS, "seed": clip.motion_seed, "crf": CRF}
    with temporary_film(scene, motion, **how) as video:
        report = verify(video, Question(badge, badge.id, camera=KnownCamera(FOCAL_PX)))
    row: dict[str, Any] = {
        "verdict": report.verdict,
        "read": report.identity.decoded_id == badge.id,
        "wrong": report.identity.decoded_id not in (None, badge.id),
        "phase_error_rad": [],
        "gain": report.invariant.gain_ratio,
        "identity_s": report.timing["stages"].get("identity"),
        "as_built": None,
        "beat_error": None,
    }
    if report.measurement is None:
        return row
    readings = read_identity(report.track, report.measurement).cells
    for (index, cell), true in true_phases_rad(clip.payload, badge.gratings).items():
        reading = readings[index][cell]
        row["phase_error_rad"].append(math.remainder(reading.free_rad - true, 2 * math.pi))
    gain, gain_sd = report.invariant.gain_ratio or math.nan, report.invariant.gain_sd or math.nan
    as_built = filmed_built(report.track, report.measurement, gain, gain_sd)[0]
    row["as_built"] = as_built.to_json()
    # The sheet's pitch in page units: its true pitch in mm, divided by the scale of the print.
    lens_page_mm = badge.lens.pitch_mm * build.lens_scale / build.print_scale
    true_beat = 1 / badge.gratings[0].pitch_mm - 1 / lens_page_mm
    row["beat_error"] = as_built.beat_period_mm * abs(true_beat) - 1
    return row
