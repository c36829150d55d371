"""Verify a film against a badge, in numbered steps.

1. Open the film.
2. Follow the badge: markers, registration, fringe profiles, frame by frame.
3. Solve for the camera: focal length, shutter, a pose a frame, smoothed.
4. Measure the fringe phase of every strip, and predict it from the optics.
5. Judge the motion invariant.
6. Decode the identity, and compare it with the claim.
7. Where the badge was enrolled as built: is it that very badge, or a copy of it?
8. Give the verdict with its reasons.

Policy: the invariant and the identity must both hold.  A failure of either rejects; a doubt of either leaves it open.
A copy is reported, and rejected where the policy asks for the original.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from moireid import __version__
from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.verifier.built import compare_built, measure_built
from moireid.verifier.identity import Identity, judge_identity
from moireid.verifier.invariant import WINDOW_FRAMES, Invariant, judge_invariant
from moireid.verifier.measure import Measurement, measure
from moireid.verifier.reasons import Level, Reason, Verdict, json_number, worst
from moireid.verifier.track import Progress, Track, track_badge
from moireid.verifier.video import Film, file_sha256

#: Fewer frames than two windows say nothing about motion.
MIN_FRAMES = 2 * WINDOW_FRAMES


@dataclass(frozen=True)
class Report:
    """The verdict with all that it rests on; `to_json` is the contract's object."""

    verdict: Verdict
    reasons: tuple[Reason, ...]
    invariant: Invariant
    identity: Identity
    badge: Badge
    film: dict[str, Any]
    frames: dict[str, int]
    timing: dict[str, Any]
    left_out: tuple[str, ...]
    track: Track = field(repr=False)
    measurement: Measurement | None = field(default=None, repr=False)
    pipeline: str = "moireid"

    def to_json(self) -> dict[str, Any]:
        """The object that `verify --json` prints."""
        camera = self.measurement.camera if self.measurement else None
        return {
            "verdict": self.verdict,
            "reasons": [reason.to_json() for reason in self.reasons],
            "invariant": self.invariant.to_json(),
            "identity": self.identity.to_json(),
            "badge": {"id": self.badge.id, "name": self.badge.name},
            "camera": {
                "focal_px": json_number(camera.focal_px),
                "focal_sd_px": json_number(camera.focal_sd_px),
                "focal_given": camera.focal_given,
                "shutter_s": json_number(camera.shutter_s),
            } if camera else None,
            "frames": self.frames,
            "mirrored": self.track.mirrored,
            "pipeline": self.pipeline,
            "timing": self.timing,
            "left_out": list(self.left_out),
            "input": self.film,
            "moireid": __version__,
        }  # fmt: skip


def verify(
    video: Path,
    badge: Badge,
    *,
    claimed_id: str | None,
    focal_px: float | None = None,
    as_built: AsBuilt | None = None,
    require_original: bool = False,
    revoked: str | None = None,
    progress: Progress | None = None,
) -> Report:
    """Verify a film.

    Parameters: badge: of the claim, or any badge of the same layout; claimed_id: the id that must be read, None
        where no identity is claimed; focal_px: where it is known; as_built: the badge's figures from enrolment;
        require_original: reject a copy, and leave open what cannot be told from one; revoked: the reason for which
        the claimed badge was revoked; progress: called with frames read and expected.
    Convention: verdict "accept" needs both invariant and identity; without a claim the invariant alone.
    Returns: Report.
    Raises: MediaError where the film cannot be read.
    Source: steps of the module docstring.
    """
    begun = time.perf_counter()
    film = Film(video)  # 1
    track = track_badge(film, badge, progress)  # 2
    stages = dict(track.stages_s)
    measurement = None
    if track.tracked < MIN_FRAMES:
        reason = _badge_absent(track)
        invariant = Invariant("inconclusive", (reason,))
        identity = Identity("unreadable" if claimed_id else "not_claimed", (), claimed_id=claimed_id)
        reasons: tuple[Reason, ...] = (reason,)
    else:
        measurement = measure(track, badge, focal_px=focal_px)  # 3, 4
        stages |= measurement.stages_s
        clock = time.perf_counter()
        invariant = judge_invariant(measurement)  # 5
        stages["invariant"] = time.perf_counter() - clock
        clock = time.perf_counter()
        identity = judge_identity(track, measurement, badge, claimed_id=claimed_id)  # 6
        stages["identity"] = time.perf_counter() - clock
        identity, built_reasons = _judge_built(
            track, measurement, badge, invariant, identity, as_built, require_original
        )  # 7
        reasons = invariant.reasons + identity.reasons + built_reasons
    if revoked is not None:
        reasons += (Reason("revoked", "fail", revoked, None, "", f"The claimed badge was revoked: {revoked}."),)
    verdict = worst(list(reasons))  # 8
    timing = {
        "total_s": round(time.perf_counter() - begun, 4),
        "stages": {name: round(seconds, 4) for name, seconds in stages.items()},
    }
    return Report(
        verdict, reasons, invariant, identity, badge,
        {"path": str(video), "sha256": file_sha256(video), "width": film.width, "height": film.height, "fps": film.fps},
        {"read": track.frames_read, "tracked": track.tracked}, timing, _left_out(badge, measurement),
        track, measurement,
    )  # fmt: skip


def _judge_built(
    track: Track, measurement: Measurement, badge: Badge, invariant: Invariant, identity: Identity,
    as_built: AsBuilt | None, require_original: bool,
) -> tuple[Identity, tuple[Reason, ...]]:  # fmt: skip
    """The identity with what is known of the building, and the reasons for it."""
    if as_built is not None:
        identity = replace(identity, expected_beat_period_mm=as_built.beat_period_mm)
    reasons: tuple[Reason, ...] = ()
    if as_built is not None and identity.verdict == "match" and invariant.verdict == "accept":
        comparison = compare_built(measure_built(track, measurement, badge, invariant), as_built, badge)
        identity, reasons = replace(identity, built=comparison.built), comparison.reasons
    if not require_original or identity.verdict != "match":
        return identity, reasons
    level: Level = "pass" if identity.built == "original" else "fail" if identity.built == "copy" else "undecided"
    text = {
        "original": "The badge is the very one that was enrolled.",
        "copy": "The badge is a copy of the enrolled one, and the original is asked for.",
    }.get(identity.built, "Whether this is the enrolled badge or a copy cannot be told.")
    return identity, (*reasons, Reason("built", level, identity.built, "original", "", text))


def _badge_absent(track: Track) -> Reason:
    text = (
        f"The badge was found in {track.tracked} of {track.frames_read} frames, at least {MIN_FRAMES} are needed; film "
        "the whole badge with its four corner markers, nearer or in better light."
    )
    return Reason("badge_absent", "undecided", float(track.tracked), float(MIN_FRAMES), "frames", text)


def _left_out(badge: Badge, measurement: Measurement | None) -> tuple[str, ...]:
    """What this film and badge did not need."""
    parts = ["colour", "the picture away from the badge once it is found"]
    if measurement and measurement.camera.focal_given:
        parts.append("solving for the focal length")
    if len({grating.axis for grating in badge.gratings}) == 1:
        parts.append(f"the {'y' if badge.gratings[0].axis == 'x' else 'x'} axis, on which the badge has no fringes")
    if all(grating.code is None for grating in badge.gratings):
        parts.append("decoding, as the board carries no code")
    return tuple(parts)
