"""The verdict with all that it is based on, and its JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.names import line_of
from moireid.provenance import Source, Standing
from moireid.question import CheckLevel
from moireid.verifier.decision.judge import Invariant, Segment
from moireid.verifier.explanations.strength import strength_json
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason, Verdict, json_number, worst
from moireid.verifier.session.cover import Cover
from moireid.verifier.signal_table import PHASES, SignalTable
from moireid.verifier.timeline import Spans
from moireid.verifier.tracking.track import Track
from moireid.version import __version__

#: Version of the JSON report; within one version, keys are only added.
REPORT_FORMAT = 2


@dataclass(frozen=True)
class Overlap:
    """Outcome of the overlap protocol: findings, when the face was seen, and when the badge covered it.

    agreeing: share of the readable frames in the longest interval that agree with the law; None if none is readable.
    """

    reasons: tuple[Reason, ...]
    faces: Spans
    overlaps: Spans
    agreeing: float | None = None

    @property
    def verdict(self) -> Verdict:
        """The verdict of the protocol alone."""
        return worst(list(self.reasons))

    def to_json(self) -> dict[str, Any]:
        """As the `overlap` object of `verify --json`."""
        longest = self.overlaps.longest
        return {
            "verdict": self.verdict,
            "longest_s": json_number(longest[1] - longest[0] if longest else 0.0),
            "total_s": json_number(float(self.overlaps.total_s)),
            "face_s": json_number(float(self.faces.total_s)),
            "agreeing": json_number(self.agreeing),
            "overlaps": self.overlaps.to_json(),
            "faces": self.faces.to_json(),
        }


@dataclass(frozen=True)
class Report:
    """The verdict with all that it is based on.

    Attributes
    ----------
    verdict : {"accept", "reject", "inconclusive"}
        The outcome.
    reasons : tuple of Reason
        Findings with measured value, limit and unit.
    invariant : Invariant
        Outcome of the motion test.
    identity : Identity
        Outcome of the identity test.
    film : dict
        The film, as `Film.described`.
    frames : dict of str to int
        Numbers of frames "read" and "tracked"; and "unsearched", in which a badge was due to be looked for and the
        whole picture was not searched.
    timing : dict
        Seconds in all and by stage.
    left_out : tuple of str
        What was not examined.
    track : Track
        Where the badge was in each frame.
    measurement : Measurement or None
        Camera and fringe phases; None if nothing could be measured.
    pipeline : str
        Which method judged: "moireid", or another one that was compared.
    segments : tuple of Segment
        The film's seconds, each judged by itself.
    region : dict or None
        Where the judged badge was first seen: the frame, and its board's corners, px.
    overlap : Overlap or None
        Whether the badge passed in front of the face; None if that was not asked for.
    cover : Cover or None
        Which seconds were judged; None for a method that does not state it.
    claim_source : {"registry", "file", "bundle"} or None
        Where the name of the badge's holder comes from; None if nothing was claimed, or a program made the claim.
    registry : Standing or None
        Authority and head of the registry, or of its bundle, that was asked; None if none was.
    level : {"record", "enrolled", "live"} or None
        What the check reached, whatever was asked for; None if it was not accepted.

    Notes
    -----
    Convention: "accept" needs the invariant, and the identity if one is claimed.  A figure that could not be measured
    is None.
    Source: the steps and the policy of `moireid.verifier.session.film`.
    """

    verdict: Verdict
    reasons: tuple[Reason, ...]
    invariant: Invariant
    identity: Identity
    film: dict[str, Any]
    frames: dict[str, int]
    timing: dict[str, Any]
    left_out: tuple[str, ...]
    track: Track = field(repr=False)
    measurement: Measurement | None = field(default=None, repr=False)
    pipeline: str = "moireid"
    segments: tuple[Segment, ...] = ()
    region: dict[str, Any] | None = None
    overlap: Overlap | None = None
    cover: Cover | None = None
    claim_source: Source | None = None
    registry: Standing | None = None
    level: CheckLevel | None = None

    def __repr__(self) -> str:
        """Short: the verdict, what failed or is undecided, and how much of the film shows the badge."""
        codes = sorted({reason.code for reason in self.reasons if reason.level in ("fail", "undecided")})
        seen = f"badge in {self.frames.get('tracked', 0)} of {self.frames.get('read', 0)} frames"
        return f"Report({self.verdict}, {self.badge.name!r}, {seen}{''.join(f', {code}' for code in codes)})"

    @property
    def badge(self) -> Badge:
        """The badge that the film was checked against."""
        return self.track.badge

    @property
    def most_informative(self) -> int:
        """Number of the grating with the most information on the motion; the plots show this one."""
        information = [figures["information"] or 0.0 for figures in self.invariant.gratings]
        return information.index(max(information)) if information else 0

    @property
    def parallax(self) -> NDArray[np.float64]:
        """Parallax coordinates of the page's middle in the frames that were measured, (T, 2)."""
        if self.measurement is None:
            return np.empty((0, 2))
        x0, y0, x1, y1 = self.badge.outline_mm
        camera = self.measurement.camera_mm
        return np.asarray((camera[:, :2] - ((x0 + x1) / 2, (y0 + y1) / 2)) / np.abs(camera[:, 2:]))

    def signals(self) -> SignalTable:
        """Give time, camera and phases of the frames that were judged.

        Returns
        -------
        SignalTable
            Arrays (T,) by the column names of signals.csv; empty where nothing could be measured.
        """
        if self.measurement is None:
            count = range(len(self.badge.gratings))
            return SignalTable.of({f"{what}_{g}": np.empty(0) for g in count for what in PHASES})
        found = self.measurement
        places = dict(zip(("camera_x_mm", "camera_y_mm", "camera_z_mm"), found.camera_mm.T, strict=True))
        places |= dict(zip(("parallax_x", "parallax_y"), self.parallax.T, strict=True))
        phases = {f"{what}_{g}": getattr(one, what) for g, one in enumerate(found.gratings) for what in PHASES}
        frames = {"frame": self.track.frame_numbers[: len(found.times_s)], "time_s": found.times_s}
        return SignalTable.of(frames | places | phases)

    def _gratings(self) -> list[dict[str, Any]]:
        """The figures of each grating, with the direction that it senses."""
        figures, gratings = self.invariant.gratings, self.badge.gratings
        return [{"axis": grating.axis} | one for grating, one in zip(gratings, figures, strict=False)]

    def to_json(self) -> dict[str, Any]:
        """Give the object that ``verify --json`` prints.

        Returns
        -------
        dict
            As `moireid.json_schema.report_schema` describes it; figures that are not finite are null.
        """
        camera = self.measurement.camera if self.measurement else None
        return {
            "format": REPORT_FORMAT,
            "verdict": self.verdict,
            "level": self.level,
            "reasons": [reason.to_json() for reason in self.reasons],
            "invariant": self.invariant.to_json() | {"gratings": self._gratings()},
            "strength": strength_json(self.invariant.strength),
            "explanations": [one.to_json() for one in self.invariant.explanations],
            "identity": self.identity.to_json(),
            "claim_source": self.claim_source,
            "registry": self.registry.to_json() if self.registry else None,
            "badge": {"id": self.badge.id, "name": self.badge.name, "line": line_of(self.badge.print)},
            "camera": {
                "focal_px": json_number(camera.focal_px),
                "focal_sd_px": json_number(camera.focal_sd_px),
                "focal_given": camera.focal_given,
                "focal_span_px": [json_number(focal) for focal in camera.focal_span_px],
                "shown": {name: json_number(share) for name, share in camera.shown.items()},
                "shutter_s": json_number(camera.shutter_s),
                "distortion_k1": json_number(camera.bend_k1),
                "distortion_sd": json_number(camera.bend_sd),
                "axis_px": [json_number(place) for place in camera.axis_px],
                "pixel_aspect": json_number(camera.aspect),
                "print_aspect": json_number(camera.print_aspect),
                "zoom": json_number(camera.zoom),
            }
            if camera
            else None,
            "frames": self.frames,
            "segments": [segment.to_json() for segment in self.segments],
            "mirrored": self.track.mirrored,
            "region": self.region,
            "overlap": self.overlap.to_json() if self.overlap else None,
            "cover": self.cover.to_json() if self.cover else None,
            "pipeline": self.pipeline,
            "timing": self.timing,
            "left_out": list(self.left_out),
            "input": self.film,
            "moireid": __version__,
            # Only the process that started this one can say how it is sealed.
            "sealed": [],
        }
