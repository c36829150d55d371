"""The capture record: films of a badge that somebody built, as signals and crops, to be compared with the prediction.

One JSON file, pictures within it as PNG in base64: every program can read it, one schema describes all of it, and two
records can be compared line by line.  A zip would be a quarter smaller and would need a layout of its own.

What it holds of people: no name, no identity and no badge.json unless they are asked for, no path, no date, no sound,
and of the pictures the fringe fields alone.  But the fringes spell the badge's code: who has the record can read its
identity from the crops, and has the figures that distinguish this badge from a copy.

Convention: phases in rad, positive where the fringe is ahead, with mean 0 in each stretch; parallax u = Cx / |Cz| of
the page's middle, positive where the camera is at +x; lengths in mm of the printed page; null where a frame is
unreadable.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.bringup.build_folder import Figure
from moireid.bringup.field_crops import FieldCrop
from moireid.errors import SpecError
from moireid.files import AnyPath, read_regular, whole_file
from moireid.frames import axis_words
from moireid.models import check_format, parse_json, read_model
from moireid.profiles import LensProfile, PrinterProfile
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.reasons import json_number
from moireid.verifier.session.result import Report
from moireid.version import __version__

FORMAT = 1
#: A record of two films has 0.4 MB; those of strangers are read no further than this.
NOTE_CHARACTERS, MOST_BYTES = 2000, 50_000_000
#: Packages whose versions may change a measurement.
PACKAGES = ("numpy", "scipy", "opencv-contrib-python-headless", "av")
Array = NDArray[np.float64]
Numbers = list[float]
Place = tuple[float, float, float]
Gaps = list[float | None]


class CropRecord(Struct, frozen=True):
    """The fringe fields in one frame, rectified onto the page, upright and grey."""

    time_s: Annotated[float, Meta(description="time in the film, s")]
    parallax_x: Annotated[float, Meta(description="Cx over the distance")]
    rect_mm: Annotated[tuple[float, float, float, float], Meta(description="left, top, right, bottom on the page, mm")]
    px_per_mm: Annotated[float, Meta(gt=0, description="pixels of the crop to a millimetre of the page")]
    png: Annotated[str, Meta(description="PNG in base64, counts as the camera coded them")]


class SignalRecord(Struct, frozen=True):
    """Measured and predicted phase of one grating, one entry per frame."""

    senses: Annotated[str, Meta(description="the direction that the grating senses, in words")]
    rect_mm: Annotated[tuple[float, float, float, float], Meta(description="left, top, right, bottom on the page, mm")]
    pitch_mm: Annotated[float, Meta(gt=0, description="nominal pitch of its lines, mm")]
    measured_rad: Annotated[Gaps, Meta(description="fringe phase; null where it is unreadable")]
    predicted_rad: Annotated[Numbers, Meta(description="by the law, under the design")]
    phase_sd_rad: Annotated[Gaps, Meta(description="standard deviation of the measured phase")]
    pose_sd_rad: Annotated[float, Meta(ge=0, description="error of the prediction from the pose")]
    stretch: Annotated[list[int], Meta(description="number of the stretch without a break; the mean is 0 in each")]


class CameraRecord(Struct, frozen=True):
    """The camera as it was solved or given; pixels of the pictures that were read."""

    focal_px: Annotated[float, Meta(gt=0)]
    focal_sd_px: Annotated[float, Meta(ge=0)]
    focal_given: Annotated[bool, Meta(description="whether it was calibrated before")]
    axis_px: Annotated[tuple[float, float], Meta(description="of the optical axis, from the picture's middle")]
    pixel_aspect: Annotated[float, Meta(gt=0)]
    distortion_k1: float
    distortion_sd: Annotated[float, Meta(ge=0)]
    shutter_s: Annotated[float, Meta(description="from the first to the last row")]


class FindingRecord(Struct, frozen=True, omit_defaults=True):
    """One finding of the verdict, without its sentence."""

    code: str
    level: Literal["pass", "fail", "undecided", "note"]
    measured: float | None = None
    limit: float | None = None
    unit: str = ""


class FilmRecord(Struct, frozen=True, omit_defaults=True):
    """One film of the badge."""

    width_px: Annotated[int, Meta(gt=0)]
    height_px: Annotated[int, Meta(gt=0)]
    frames_read: Annotated[int, Meta(ge=0)]
    verdict: Annotated[Literal["accept", "reject", "inconclusive"], Meta(description="as judged for an enrolment")]
    findings: list[FindingRecord]
    gain: Annotated[float | None, Meta(description="measured over predicted motion")] = None
    gain_sd: float | None = None
    camera: CameraRecord | None = None
    time_s: Annotated[Numbers, Meta(description="times of the frames, s")] = []
    camera_mm: Annotated[list[Place], Meta(description="camera centre, page mm; z is negative")] = []
    parallax_x: Numbers = []
    parallax_y: Numbers = []
    signals: list[SignalRecord] = []
    crops: list[CropRecord] = []
    as_built: Annotated[dict[str, Any] | None, Meta(description="figures as enrolment would store them")] = None


class CaptureRecord(Struct, frozen=True, omit_defaults=True):
    """Films of one physical badge, to be shared."""

    format: Literal[1]
    kind: Literal["moireid-capture-record"]
    made_by: Annotated[dict[str, str], Meta(description="versions of the programs that measured")]
    lens: Annotated[dict[str, Any], Meta(description="the sheet that the badge was printed for")]
    print: Annotated[dict[str, Any], Meta(description="how it was printed")]
    films: list[FilmRecord]
    figures: Annotated[list[Figure], Meta(description="what first-badge found, with error bars")] = []
    sheet: Annotated[dict[str, Any] | None, Meta(description="the lens profile")] = None
    printer: Annotated[dict[str, Any] | None, Meta(description="the printer profile")] = None
    badge: Annotated[dict[str, Any] | None, Meta(description="badge.json with its name, if asked for")] = None
    note: Annotated[str, Meta(max_length=NOTE_CHARACTERS, description="what the builder wrote")] = ""


def film_record(report: Report, built: AsBuilt | None, crops: Sequence[FieldCrop]) -> FilmRecord:
    """One film as a record: without its path, its sentences and its id."""
    width, height = report.track.image_px
    findings = [
        FindingRecord(one.code, one.level, _number(one.measured), _number(one.limit), one.unit)
        for one in report.reasons
    ]
    base = {
        "width_px": width,
        "height_px": height,
        "frames_read": report.frames["read"],
        "verdict": report.verdict,
        "findings": findings,
        "gain": json_number(report.invariant.gain_ratio),
        "gain_sd": json_number(report.invariant.gain_sd),
        "as_built": None if built is None else {k: v for k, v in asdict(built).items() if k != "badge_id"},
    }
    found = report.measurement
    if found is None:
        return FilmRecord(**base)
    parallax, camera = report.parallax, found.camera
    solved = CameraRecord(
        camera.focal_px,
        camera.focal_sd_px,
        camera.focal_given,
        camera.axis_px,
        camera.aspect,
        camera.bend_k1,
        camera.bend_sd,
        camera.shutter_s,
    )
    shown = [
        CropRecord(one.time_s, float(parallax[one.number, 0]), one.rect_mm, one.px_per_mm, one.png_base64())
        for one in crops
    ]
    return FilmRecord(
        **base,
        camera=solved,
        time_s=_rounded(found.times_s),
        camera_mm=[(x, y, z) for x, y, z in np.round(found.camera_mm, 3).tolist()],
        parallax_x=_rounded(parallax[:, 0]),
        parallax_y=_rounded(parallax[:, 1]),
        signals=[_signal(report, g, signal) for g, signal in enumerate(found.gratings)],
        crops=shown,
    )


def _signal(report: Report, number: int, signal: GratingSignal) -> SignalRecord:
    grating = report.badge.gratings[number]
    readable = np.isfinite(signal.phase_sd_rad)
    return SignalRecord(
        axis_words(grating.axis),
        grating.rect_mm,
        grating.pitch_mm,
        _with_gaps(signal.measured_rad, readable),
        _rounded(signal.predicted_rad),
        _with_gaps(signal.phase_sd_rad, readable),
        float(signal.pose_sd_rad),
        signal.stretch.tolist(),
    )


def _number(value: object) -> float | None:
    """A finding's figure; words, which may hold a name, are left out."""
    found = json_number(float(value)) if isinstance(value, int | float) else None
    return found if isinstance(found, float) else None


def _rounded(values: Array) -> list[float]:
    return [float(f"{value:.6g}") for value in values.tolist()]


def _with_gaps(values: Array, readable: NDArray[np.bool_]) -> list[float | None]:
    return [value if there else None for value, there in zip(_rounded(values), readable.tolist(), strict=True)]


def capture_record(
    films: Sequence[FilmRecord],
    badge: Badge,
    *,
    figures: Sequence[Figure] = (),
    sheet: LensProfile | None = None,
    printer: PrinterProfile | None = None,
    with_badge: bool = False,
    note: str = "",
) -> CaptureRecord:
    """The record of some films.

    Parameters
    ----------
    with_badge : bool
        Whether badge.json goes with it, which has name and identity.
    note : str
        Words of the builder, such as where the sheet was bought.
    """
    made_by = {"moireid": __version__, "python": platform.python_version()}
    return CaptureRecord(
        1,
        "moireid-capture-record",
        made_by | {package: version(package) for package in PACKAGES},
        {key: value for key, value in asdict(badge.lens).items() if value is not None},
        {key: value for key, value in (badge.print or {}).items() if key in ("dpi", "paper", "form", "ink_growth_um")},
        list(films),
        list(figures),
        None if sheet is None else json.loads(sheet.to_json()),
        None if printer is None else json.loads(printer.to_json()),
        json.loads(badge.to_json()) if with_badge else None,
        note,
    )


def write_record(record: CaptureRecord, path: AnyPath) -> None:
    """Write a record, whole or not at all.  Raises: SpecError if it does not read back."""
    with whole_file(path) as temporary:
        temporary.write_bytes(msgspec.json.format(msgspec.json.encode(record), indent=1) + b"\n")
        read_record(temporary)


def read_record(path: AnyPath) -> CaptureRecord:
    """Read a capture record.  Raises: SpecError if it is none, or larger than `MOST_BYTES`."""
    source, advice = f"capture record {path}", "give a file that moireid first-badge --record wrote"
    try:
        text = read_regular(path, MOST_BYTES).decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise SpecError(f"{source} cannot be read ({reason}); {advice}") from error
    document = parse_json(text, source, advice)
    check_format(document, FORMAT, source)
    return read_model(document, CaptureRecord, source, advice)
