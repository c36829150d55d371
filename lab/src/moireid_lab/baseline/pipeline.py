"""The published pipeline (Qing et al., *Moiré Video Authentication*, 2026), a baseline to compare ours with.

1. Corners of the four markers by ArUco with its default settings, or four corners tracked by `corners`.
2. A homography rectifies the striped region; CLAHE equalises its contrast.
3. The fringes' orientation from their contours; the region is rotated until they are upright.
4. Column means; the Fourier bin of the greatest power in the first frame is kept; its angle is the fringe phase.
5. The camera's pose by PnP from the markers' centres with a guessed focal length; the phase should follow its place
   over its distance across the fringes, with the orientation of the *first* frame, or of each frame where rotation is
   not compensated.
6. Pearson correlation over windows of 30 frames; the greatest of its magnitude is the score, 0.927 and more is
   accepted.

Convention: the region is the badge's reference cell, as the published board has one uniform grating; correlation does
    not test sign and gain, and so neither does this pipeline.  The guessed focal length is the picture's longer side.
    The paper leaves films of score 0 out of its figures; such a film has no score here, and is counted.
Source: the paper's text.  What it does not say is set here: CLAHE has clip 2 and 8 x 8 tiles, corners are refined by
    OpenCV's `CORNER_REFINE_SUBPIX`, and a frame in which a marker is missing is left out.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Rect
from moireid.question import KnownCamera, Question
from moireid.verifier.decision.figures import pearson, window_correlations
from moireid.verifier.decision.judge import Invariant
from moireid.verifier.identity.decode import Identity
from moireid.verifier.limits import WINDOW_FRAMES
from moireid.verifier.reasons import Reason, json_number, worst
from moireid.verifier.session.claim import claim_reasons
from moireid.verifier.session.result import Report
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.track import no_track
from moireid.verifier.video import Film, Progress
from moireid_lab.baseline.corners import CornerFollower, Corners

Array = NDArray[np.float64]
#: Rectified pixels per millimetre, and the most along either side.
PX_PER_MM, MOST_PX = 6.0, 1200.0
CLAHE_CLIP, CLAHE_TILES = 2.0, (8, 8)
#: The paper's own threshold, which gave the greatest accuracy on its films.
THRESHOLD = 0.927
#: Contours below this share of the region are ignored.
SPECK_SHARE = 0.002


@dataclass(frozen=True)
class PublishedInvariant(Invariant):
    """With |rho| over windows: its greatest value, which is the score, its least, and its standard deviation."""

    window_correlation_max: float | None = None
    window_correlation_min: float | None = None
    window_correlation_sd: float | None = None

    def to_json(self) -> dict[str, Any]:
        """As the `invariant` object of `verify --json`, with what this pipeline adds."""
        names = ("window_correlation_max", "window_correlation_min", "window_correlation_sd")
        return super().to_json() | {name: json_number(getattr(self, name)) for name in names}


def verify_published(
    video: Path, claim: Question, *, corners: Corners | None = None, progress: Progress | None = None
) -> Report:
    """Score a film as the published pipeline does.

    Parameters: as `film.verify`; badge, identity and focal length of the claim are used; corners: the striped region's
        corners at some frames, in place of markers.
    Returns: Report; no identity is read, so a claimed identity stays unconfirmed.
    Raises: MediaError if the film cannot be read.
    Source: module docstring.
    """
    begun = time.perf_counter()
    film = Film(video)
    reader = read_film(film, claim, corners=corners, progress=progress)
    place, read = reader.places, reader.read
    invariant = judge(np.unwrap(reader.phases), np.array(place), read)
    reasons = invariant.reasons + film.findings()
    identity = Identity("unreadable" if claim.names_someone else "not_claimed", (), claimed_id=claim.badge_id)
    if claim.names_someone:
        text = "The published pipeline does not read identities, so it cannot say whose badge this is."
        reasons += (Reason("identity", "undecided", None, None, "", text),)
    reasons += claim_reasons(claim, identity)
    total_s = round(time.perf_counter() - begun, 4)
    return Report(
        worst(list(reasons)),
        reasons,
        invariant,
        identity,
        film.described(),
        {"read": read, "tracked": len(place)},
        {"total_s": total_s, "stages": {"film": total_s}},
        ("identity", "gain"),
        no_track(claim.badge, read, (film.width, film.height)),
        None,
        pipeline="published",
        claim_source=claim.provenance.source,
        registry=claim.provenance.standing,
    )


def read_film(
    film: Film,
    claim: Question,
    *,
    corners: Corners | None = None,
    compensated: bool = True,
    progress: Progress | None = None,
) -> PublishedReader:
    """All frames of a film, read; compensated: whether the camera's rotation is left out of its place."""
    reader = PublishedReader(claim.badge, corners, (film.width, film.height), claim.camera, compensated)
    for frame in film.frames_ahead():
        reader.push(frame.index, frame.luma)
        if progress:
            progress(reader.read, film.frames_expected)
    return reader


def judge(measured: Array, place: Array, read: int) -> PublishedInvariant:
    """The score of one film: phase (T,) rad against place over distance (T,)."""
    if len(measured) < WINDOW_FRAMES:
        text = f"The badge was found in {len(measured)} of {read} frames; at least {WINDOW_FRAMES} are needed."
        reason = Reason("badge_absent", "undecided", float(len(measured)), float(WINDOW_FRAMES), "frames", text)
        return PublishedInvariant("inconclusive", (reason,))
    windows = np.abs(window_correlations(measured, place))
    score = float(windows.max())
    if score == 0:
        text = "Fringe phase or camera position never changes, so they have no correlation."
        reason = Reason("window_correlation", "undecided", score, THRESHOLD, "", text)
        return PublishedInvariant("inconclusive", (reason,))
    good = score >= THRESHOLD
    text = (
        f"Over windows of {WINDOW_FRAMES} frames, fringe phase and camera position correlate by up to {score:.3f}; at "
        f"least {THRESHOLD} is needed."
    )
    reason = Reason("window_correlation", "pass" if good else "fail", score, THRESHOLD, "", text)
    return PublishedInvariant(
        worst([reason]),
        (reason,),
        correlation=abs(pearson(measured, place)),
        window_correlation_mean=float(windows.mean()),
        score=score,
        window_correlation_max=score,
        window_correlation_min=float(windows.min()),
        window_correlation_sd=float(windows.std()),
    )


class PublishedReader:
    """Phase of the region and place of the camera, frame after frame."""

    def __init__(
        self,
        badge: Badge,
        corners: Corners | None,
        image_px: tuple[int, int],
        camera: KnownCamera | None,
        compensated: bool = True,
    ) -> None:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, badge.squares.dictionary))
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._detector = cv2.aruco.ArucoDetector(dictionary, parameters)
        self._markers = badge.squares
        grating = badge.gratings[0]
        self._upright = grating.axis == "x"
        self._region = grating.cells[grating.code.reference_cell if grating.code else 0].rect_mm
        self._field = grating.rect_mm
        self._middle = np.array([(self._field[0] + self._field[2]) / 2, (self._field[1] + self._field[3]) / 2])
        self._follower = CornerFollower(corners) if corners else None
        focal = camera.focal_px(max(image_px)) if camera else float(max(image_px))
        self._camera = np.array([[focal, 0, (image_px[0] - 1) / 2], [0, focal, (image_px[1] - 1) / 2], [0, 0, 1.0]])
        self._clahe = cv2.createCLAHE(CLAHE_CLIP, CLAHE_TILES)
        self._bin: int | None = None
        self._first: Array | None = None
        self._compensated = compensated
        self.read = 0
        self.frames: list[int] = []
        self.phases: list[float] = []
        self.places: list[float] = []

    def push(self, index: int, luma: NDArray[np.uint8]) -> None:
        """Read one frame; it is skipped if the region is not found."""
        self.read += 1
        found = self._points(index, luma)
        if found is None:
            return
        page, image = found
        homography, _ = cv2.findHomography(page.reshape(-1, 2), image.reshape(-1, 2), 0)
        flat = np.column_stack([page.mean(axis=1) - self._middle, np.zeros(4)])
        solved, turn, shift = cv2.solvePnP(flat, image.mean(axis=1), self._camera, None, flags=cv2.SOLVEPNP_ITERATIVE)
        if homography is None or not solved:
            return
        self.frames.append(index)
        self.phases.append(self._phase(upright_region(luma, homography, self._region, self._upright, self._clahe)))
        orientation, _ = cv2.Rodrigues(turn)
        if self._first is None or not self._compensated:
            self._first = np.asarray(orientation, float)
        seen = self._first @ (orientation.T @ shift.ravel())
        # Across the fringes as the picture shows them, however the board is turned in it.
        across = self._first[:2, 0 if self._upright else 1]
        self.places.append(float(seen[:2] @ across / (np.linalg.norm(across) * seen[2])))

    def _points(self, index: int, luma: NDArray[np.uint8]) -> tuple[Array, Array] | None:
        """Matching points of page, mm, and picture, px: the markers' corners (4, 4, 2), or the region's (4, 1, 2)."""
        if self._follower is not None:
            followed = self._follower.follow(index, luma)
            x0, y0, x1, y1 = self._field
            corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
            return None if followed is None else (corners[:, None], followed[:, None])
        quads, identities, _ = self._detector.detectMarkers(luma)
        seen = {} if identities is None else dict(zip(np.ravel(identities).tolist(), quads, strict=True))
        if not seen.keys() >= set(self._markers.ids):
            return None
        image = np.array([seen[number].reshape(4, 2) for number in self._markers.ids], float)
        return np.asarray(marker_corners_mm(self._markers), float), image

    def _phase(self, region: NDArray[np.uint8]) -> float:
        """Angle of the Fourier bin that was strongest in the first frame."""
        columns = region.mean(axis=0)
        spectrum = np.fft.rfft(columns - columns.mean())
        if self._bin is None:
            self._bin = 1 + int(np.argmax(np.abs(spectrum[1:])))
        return float(np.angle(spectrum[self._bin]))


def upright_region(
    luma: NDArray[np.uint8], homography: Array, region: Rect, upright: bool, clahe: cv2.CLAHE
) -> NDArray[np.uint8]:
    """The region rectified, equalised, and rotated so that its fringes are upright, (height, width)."""
    x0, y0, x1, y1 = region
    scale = min(PX_PER_MM, MOST_PX / max(x1 - x0, y1 - y0))
    to_page = np.array([[1 / scale, 0, x0], [0, 1 / scale, y0], [0, 0, 1.0]])
    size = (max(round((x1 - x0) * scale), 8), max(round((y1 - y0) * scale), 8))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    flat = cv2.warpPerspective(luma, homography @ to_page, size, flags=flags)
    flat = np.ascontiguousarray(flat if upright else flat.T)
    flat = clahe.apply(flat)
    lean = fringe_lean_rad(flat)
    centre = ((flat.shape[1] - 1) / 2, (flat.shape[0] - 1) / 2)
    turn = cv2.getRotationMatrix2D(centre, float(np.degrees(lean)), 1.0)
    return np.asarray(
        cv2.warpAffine(flat, turn, (flat.shape[1], flat.shape[0]), borderMode=cv2.BORDER_REPLICATE), np.uint8
    )


def fringe_lean_rad(region: NDArray[np.uint8]) -> float:
    """Angle of the fringes from upright, by the mean direction of their contours' long sides.

    Convention: the angle by which OpenCV's rotation (positive: anticlockwise as seen) makes them upright; 0 if no
        contour is long enough to have a direction.
    """
    # Blur printed lines, half a millimetre wide, so that they do not count as fringes.
    soft = cv2.GaussianBlur(region, (0, 0), PX_PER_MM / 2)
    _, dark = cv2.threshold(soft, 0, 255, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    contours, _ = cv2.findContours(dark, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    total = 0.0 + 0.0j
    for contour in contours:
        area = cv2.contourArea(contour)
        if area < SPECK_SHARE * region.size:
            continue
        points = cv2.boxPoints(cv2.minAreaRect(contour))
        sides = [points[1] - points[0], points[2] - points[1]]
        x, y = max(sides, key=lambda side: float(side @ side))
        # A direction and its opposite are the same, so angles are doubled before averaging.
        total += area * np.exp(2j * np.arctan2(x, y))
    return float(-np.angle(total) / 2) if abs(total) > 0 else 0.0
