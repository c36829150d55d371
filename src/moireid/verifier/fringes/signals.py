"""From the track to two signals: the measured fringe phase, and the phase that the optics predict.

Each strip is measured by itself.  Then all strips of a grating are combined into one signal, weighted by their Fisher
information (one over the variance of a phase).  The offset of a strip is a nuisance parameter: it depends on how the
sheet was placed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Grating
from moireid.frames import OwnFrame, own_rect
from moireid.lenticule import critical_tangent
from moireid.question import KnownCamera
from moireid.verifier import limits, measuring
from moireid.verifier.camera.fit import CameraFit, fit_camera
from moireid.verifier.camera.page_shape import gain_sd_share
from moireid.verifier.camera.smoothing import smooth_camera, without_outliers
from moireid.verifier.camera.stretches import stretch_numbers, within_stretches
from moireid.verifier.fringes.all_strips import measure_strips
from moireid.verifier.fringes.beyond_phase import expected_overtone, mean_overtone
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal
from moireid.verifier.fringes.mixed_frames import carried_rad, mixed_share
from moireid.verifier.fringes.place_map import PlaceMap, start_maps
from moireid.verifier.fringes.sinusoid import joined_frames, numbered, unwrap
from moireid.verifier.fringes.strip_law import air_law, within_law
from moireid.verifier.fringes.strip_phase import StripPhase, rounding_rad
from moireid.verifier.fringes.uneven_air import less_uneven_air
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.track import Track

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measurement:
    """Everything measured in a film: camera, strips, and one signal per grating.

    strips: one per strip of the track; None for rows of phase cells, which are read with the identity; maps: one per
    grating.
    """

    camera: CameraFit
    camera_mm: Array
    times_s: Array
    strips: tuple[StripPhase | None, ...]
    gratings: tuple[GratingSignal, ...]
    maps: tuple[PlaceMap, ...]
    stages_s: dict[str, float] = field(default_factory=dict)

    def under(self, gain: float) -> Measurement:
        """The same with each grating's signal under that gain; the predictions of its strips stay the design's."""
        return replace(self, gratings=tuple(signal.under(gain) for signal in self.gratings))


def measure(
    track: Track,
    *,
    camera: KnownCamera | None = None,
    enrolled_maps: Sequence[Sequence[float]] = (),
) -> Measurement:
    """Measure a track of at least a few frames.

    Parameters
    ----------
    track : Track
        Of one badge; of its code only the layout is used.
    camera : KnownCamera, optional
        What is known of the camera; all else is estimated.
    enrolled_maps : sequence of sequences of float
        As `AsBuilt.place_maps`; none if the badge was not measured as built.

    Returns
    -------
    Measurement

    Raises
    ------
    SpecError
        The enrolled maps are not of this badge.

    Notes
    -----
    Convention: phases as `strip_phase`.
    Source: `camera.fit`, `strip_phase`, `strip_law`, and the combination in `_combine`.
    """
    clock, badge = time.perf_counter(), track.badge
    page_mm = marker_corners_mm(badge.markers).reshape(-1, 2)
    homogeneous = np.column_stack([page_mm, np.ones(len(page_mm))])
    mapped = np.einsum("tij,nj->tni", track.homographies, homogeneous)
    points_px = mapped[..., :2] / mapped[..., 2:]
    fit = fit_camera(points_px, page_mm, track.times_s, track.image_px, camera=camera)
    raw_mm, good = without_outliers(fit.camera_mm, fit.reprojection_px, track.times_s)
    stray_share = float(np.mean(~good))
    covered = page_covered(track.correlations)
    good &= ~covered
    numbers = stretch_numbers(track.times_s, raw_mm[:, :2] / raw_mm[:, 2:], fit.cuts)
    raw_mm, _ = without_outliers(fit.camera_mm, fit.reprojection_px, track.times_s, numbers)
    camera_mm = smooth_camera(raw_mm, track.times_s, fit.tangent_error, track.vague, numbers)
    posed = time.perf_counter()
    strips, maps = measure_strips(track, badge, camera_mm, start_maps(badge, enrolled_maps))
    enlarged, doubt = _small_marker_factors(points_px)
    poses = _Poses(
        fit,
        camera_mm,
        page_mm,
        *_pose_noise(raw_mm, camera_mm, good),
        enlarged,
        doubt,
        good,
        numbers,
        stray_share,
        covered,
    )
    gratings = tuple(_grating_signal(track, badge, g, strips, poses) for g in range(len(badge.gratings)))
    stages = {"pose": posed - clock, "fringe": time.perf_counter() - posed}
    return Measurement(fit, camera_mm, track.times_s, tuple(strips), gratings, maps, stages)


def page_covered(correlations: Array) -> NDArray[np.bool_]:
    """Frames in which something covers a part of the markers, so that their pose errs; (T,).

    Parameters: correlations (T,): of picture and print, as `Track` has them.
    """
    usual = float(np.median(correlations))
    scatter = 1.4826 * float(np.median(np.abs(correlations - usual)))
    return np.asarray(
        correlations < usual - max(measuring.COVERED_CORRELATION, measuring.COVERED_CORRELATION_SDS * scatter)
    )


@dataclass(frozen=True)
class _Poses:
    """What all gratings share: the camera's path and its errors.

    camera_mm (T, 3), smoothed; page_mm (N, 2): the markers' corners; jitter (2,): standard deviation of the parallax
    coordinates about the smoothed path, from the median deviation; removed (2,): the same from all well-registered
    frames; enlarged, doubt: as `_small_marker_factors`; good (T,): well-registered frames;
    stretch (T,): as `camera.stretches.stretch_numbers`; stray_share: as in `GratingSignal`;
    covered (T,): frames whose markers are covered in part.
    """

    camera: CameraFit
    camera_mm: Array
    page_mm: Array
    jitter: Array
    removed: Array
    enlarged: float
    doubt: float
    good: NDArray[np.bool_]
    stretch: NDArray[np.int64]
    stray_share: float
    covered: NDArray[np.bool_]


def _grating_signal(
    track: Track, badge: Badge, index: int, strips: Sequence[StripPhase | None], poses: _Poses
) -> GratingSignal:
    """The signal of one grating from all its strips, with error bars that include the poses."""
    grating = badge.gratings[index]
    every = [found for strip, found in zip(track.strips, strips, strict=True) if strip.grating == index and found]
    own = _uncovered(every)
    clear = sum(float(np.mean(~strip.covered & ~poses.covered)) for strip in own)
    frame = badge.frame_of(grating)
    low, top, high, bottom = own_rect(grating.axis, grating.rect_mm)
    middle = np.array([(low + high) / 2, (top + bottom) / 2])
    away = middle - frame.places(poses.camera_mm[:, :2])
    tangents = away / np.abs(poses.camera_mm[:, 2:])
    rounding = float(np.median([rounding_rad(strip) for strip in own])) if own else 0.0
    jitter, removed, whole = (
        float(frame.spreads(pair)[0]) for pair in (poses.jitter, poses.removed, poses.camera.tangent_error)
    )
    # The larger of two estimates: from the reprojection errors, and from what smoothing removed.
    slow = measuring.SLOW_ERROR_RATIO * poses.camera.slow_to_fast * removed
    tangent_error = max(poses.enlarged * _after_smoothing(jitter, whole, rounding), slow)
    air = air_law(badge.lens, grating.pitch_mm, *tangents.T)
    slope = 2 * np.pi * badge.lens.thickness_mm / badge.lens.refractive_index / grating.pitch_mm
    known = within_law(track.strips, poses.camera_mm) & poses.good
    signal = _combine(own, slope * tangent_error, track.times_s, poses.stretch, air, known)
    sd = np.where(known, signal.phase_sd_rad, np.inf)
    if track.vague is not None:
        # `pose_sd_rad` is the error of a typical frame; a frame with a worse pose gets a larger error bar.
        vague = frame.spreads(track.vague)[:, 0]
        vague = np.maximum(vague / np.median(vague), 1.0)
        sd = np.hypot(sd, signal.pose_sd_rad * np.sqrt(vague**2 - 1))
    return replace(
        signal,
        phase_sd_rad=sd,
        place_residual_rad=np.array([strip.place_residual_rad for strip in own]),
        tangent_sd=math.hypot(
            float(frame.spreads(poses.camera.tangent_sd)[0]),
            gain_sd_share(badge, grating, poses.page_mm, poses.camera.twist_per_m),
        ),
        shape_sd_rad=slope * float(frame.spreads(poses.camera.tangent_shape)[0]),
        covariates=_covariates(poses.camera_mm, poses.page_mm, frame),
        rounding_rad=rounding,
        covered_share=1 - clear / max(len(every), 1),
        held_share=0.0 if track.vague is None else float(np.mean((track.vague > 1).any(axis=1))),
        stray_share=poses.stray_share,
        focal_at_limit=poses.camera.focal_at_limit,
        lasting_px=poses.camera.lasting_px,
        doubt=poses.doubt,
        zoom=poses.camera.zoom,
        mixed_share=_mixed(own, known, track, frame, middle) if own else 0.0,
        beyond=_beyond(own, known, track, frame, grating, tangents, poses.page_mm.mean(axis=0)) if own else None,
        lens_room=poses.camera.lens_room,
        parallel=poses.camera.parallel,
        aside_share=float(np.mean(np.linalg.norm(tangents, axis=1) > critical_tangent(badge.lens))),
    )


def _beyond(
    strips: list[StripPhase],
    known: NDArray[np.bool_],
    track: Track,
    frame: OwnFrame,
    grating: Grating,
    tangents: Array,
    middle_mm: Array,
) -> BeyondPhase:
    """As `GratingSignal.beyond`.

    Parameters: known (T,): frames with a good pose; tangents (T, 2): of the view at the grating's middle; middle_mm
        (2,): of the markers, page mm.
    """
    depth = (np.sum(series, axis=0) for series in zip(*(strip.depth for strip in strips if strip.depth), strict=True))
    place = track.homographies @ np.append(middle_mm, 1.0)
    spread_cycles = float(frame.spreads(track.spread_mm)[0] * np.mean([strip.frequency_per_mm for strip in strips]))
    return BeyondPhase(
        np.mean([strip.predicted_rad for strip in strips], axis=0),
        DepthLaw(*(np.where(known, values, 0.0) for values in depth)),
        mean_overtone(strips),
        place[:, :2] / place[:, 2:],
        expected_overtone(track.badge.lens, grating, *tangents.T, spread_cycles=spread_cycles),
    )


def _mixed(
    strips: list[StripPhase], known: NDArray[np.bool_], track: Track, frame: OwnFrame, middle_mm: Array
) -> float:
    """As `mixed_frames.mixed_share`, of the mean of a grating's strips; known (T,): frames with a good pose."""
    contrast = np.mean([strip.contrast / max(float(np.median(strip.contrast)), 1e-9) for strip in strips], axis=0)
    clear = known & ~np.any([strip.covered for strip in strips], axis=0)
    frequency = float(np.mean([strip.frequency_per_mm for strip in strips]))
    carried = carried_rad(track.homographies, frame, middle_mm, frequency, track.times_s)
    predicted = np.mean([strip.predicted_rad for strip in strips], axis=0)
    return mixed_share(np.where(clear, contrast, np.nan), carried, predicted)


def _uncovered(strips: list[StripPhase]) -> list[StripPhase]:
    """The strips without those that a hand or a caption covers all film long.

    They are far vaguer than the clearest strip, or fringes explain far less of them.
    """
    vague = np.array([np.median(strip.phase_sd_rad) for strip in strips])
    misfit = np.array([strip.misfit for strip in strips])
    covered = vague > limits.MAX_VAGUENESS_RATIO * vague.min(initial=math.inf)
    floor = max(misfit.min(initial=math.inf), measuring.COVERED_MISFIT_CONTRASTS / measuring.COVERED_MISFIT_RATIO)
    covered |= misfit > measuring.COVERED_MISFIT_RATIO * floor
    return [strip for strip, hidden in zip(strips, covered, strict=True) if not hidden]


def _covariates(camera_mm: Array, page_mm: Array, frame: OwnFrame) -> Array:
    """The camera's parallax along the lines, and one over its distance, (T, 2)."""
    near = 1 / np.abs(camera_mm[:, 2])
    sideways = frame.places(camera_mm[:, :2])[:, 1] - frame.places(page_mm)[:, 1].mean()
    return np.column_stack([sideways * near, near])


def _small_marker_factors(corners_px: Array) -> tuple[float, float]:
    """By how much pose errors exceed their estimate, and may exceed even that, from the markers' size.

    Parameters: corners_px (T, 16, 2).
    """
    quads = corners_px.reshape(len(corners_px), 4, 4, 2)
    side = float(np.median(np.linalg.norm(np.diff(quads[:, :, :3], axis=2), axis=-1)))
    enlarged = math.pow(max(1.0, measuring.SMALL_MARKER_PX / max(side, 1.0)), measuring.SMALL_MARKER_POWER)
    return enlarged, limits.SMALL_MARKER_WORST_RATIO if side < limits.DOUBTED_MARKER_PX else 1.0


def _pose_noise(raw_mm: Array, smooth_mm: Array, good: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Standard deviations of the parallax coordinates (x, y) about the smoothed path: from the median deviation, and
    of all well-registered frames, as errors come in spells.
    """
    wander = raw_mm[:, :2] / raw_mm[:, 2:] - smooth_mm[:, :2] / smooth_mm[:, 2:]
    every = wander[good] if good.any() else wander
    return 1.4826 * np.median(np.abs(wander), axis=0), np.sqrt((every**2).mean(axis=0))


def _after_smoothing(wander: float, whole: float, rounding: float) -> float:
    """Error of a parallax coordinate after smoothing: a share of its fast part, and all of its slow part.

    whole: the total error, from reprojection errors; wander: its fast part, which smoothing removed; rounding: as
    `strip_phase.rounding_rad`, since markers and lines are printed with the same ink.
    """
    slow = math.sqrt(max(whole**2 - wander**2, 0.0))
    share = min(1.0, math.hypot(measuring.SMOOTHED_SHARE, rounding / measuring.ROUNDING_ONLY_RAD))
    return math.hypot(share * wander, slow)


def _combine(
    strips: list[StripPhase],
    pose_sd_rad: float,
    times_s: Array,
    stretch: NDArray[np.int64],
    air_rad: Array,
    known: NDArray[np.bool_],
) -> GratingSignal:
    """One signal from several strips, which are compared in the frames that are known.

    Strips of another pitch move a little faster or slower; `gain` scales each to the mean strip.  Offsets and signal
    are estimated in turn, on the circle, so that no strip must be unwrapped by itself.
    """
    phase = np.array([strip.phase_rad for strip in strips])
    sd = np.array([strip.phase_sd_rad for strip in strips])
    weight = np.where(sd < measuring.MAX_PHASE_SD_RAD, 1.0 / np.maximum(sd, 1e-3) ** 2, 0.0)
    predicted = np.array([strip.predicted_rad for strip in strips])
    predicted = predicted - predicted.mean(axis=1, keepdims=True)
    common = predicted.mean(axis=0)
    power = float(common @ common)
    gain = predicted @ common / power if power > 0 else np.ones(len(strips))
    # A covered strip has no phase; unwrapping its noise would add whole turns.
    clear = np.flatnonzero(weight.any(axis=0))
    segments = [clear[part] for part in joined_frames(common[clear], times_s[clear], stretch[clear])]
    signal = unwrap(phase[int(np.argmax(weight.sum(axis=1)))], common, segments)
    for _ in range(4):
        expected = signal + (gain[:, None] - 1.0) * (signal - signal.mean())
        apart = phase - expected
        offset = np.angle((weight * np.exp(1j * apart)).sum(axis=1))
        turned = np.angle(np.exp(1j * (apart - offset[:, None])))
        total = weight.sum(axis=0)
        correction = np.where(total > 0, (weight * turned).sum(axis=0) / np.maximum(total, 1e-12), 0.0)
        signal = unwrap(signal + correction, common, segments)
    total = weight.sum(axis=0)
    with np.errstate(divide="ignore"):
        phase_sd = np.where(total > 0, 1 / np.sqrt(total), np.inf)
    weight = weight * known
    turned = less_uneven_air(turned, weight, common, air_rad)
    contrast = np.array([strip.contrast / max(float(np.median(strip.contrast)), 1e-9) for strip in strips])
    dimmed = contrast - (weight * contrast).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-12)
    dimmed -= (weight * dimmed).sum(axis=1, keepdims=True) / np.maximum(weight.sum(axis=1, keepdims=True), 1e-12)
    wander, noise = (
        np.sqrt((weight * apart**2).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-12)) for apart in (turned, dimmed)
    )
    strip_sd = np.array(
        [
            np.median(own[own < measuring.MAX_PHASE_SD_RAD]) if (own < measuring.MAX_PHASE_SD_RAD).any() else 0.0
            for own in sd
        ]
    )
    numbers = numbered(segments, len(times_s))
    return GratingSignal(
        within_stretches(signal, numbers),
        within_stretches(common, numbers),
        phase_sd,
        pose_sd_rad,
        wander,
        times_s,
        strip_noise_rad=noise,
        strip_sd_rad=strip_sd,
        stretch=numbers,
        phase_rad=signal,
        air_rad=within_stretches(air_rad, numbers),
    )
