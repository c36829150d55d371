"""What a film is asked: whose badge it should show, what is known of that badge, and what an acceptance needs.

A registry, a bundle or a file fills in the badge; who asks adds the rest, by `dataclasses.replace`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

from moireid.asbuilt import AsBuilt, DatedFigures
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.names import line_of
from moireid.provenance import OWN_CLAIM, Provenance, Revocation, Seal

CheckLevel = Literal["record", "enrolled", "live"]
#: Width over height of film and calibration differ by this share at most, else one of them shows a part of the picture.
SAME_SHAPE_SHARE = 0.01


@dataclass(frozen=True)
class KnownCamera:
    """What is known of the camera of a film before it is read.

    Parameters
    ----------
    focal : float
        Focal length over the long side of the picture, in pixels of the height; where `size_px` is None in pixels of
        the film.
    size_px : (int, int), optional
        Width and height of the pictures that it was calibrated with; None where the focal length alone is known, and
        all else is estimated from the film.
    axis : (float, float)
        Where the optical axis meets the picture, from its middle, in long sides of the picture; x right, y down.
    aspect : float
        Focal length along x over that along y, in pixels; 1 for square pixels.
    k1, k2 : float
        Radial distortion of Brown's model (OpenCV's), in units of the focal length.
    """

    focal: float
    size_px: tuple[int, int] | None = None
    axis: tuple[float, float] = (0.0, 0.0)
    aspect: float = 1.0
    k1: float = 0.0
    k2: float = 0.0

    @property
    def calibrated(self) -> bool:
        """Whether nothing of the camera is left to estimate."""
        return self.size_px is not None

    def focal_px(self, long_side_px: int) -> float:
        """The focal length in pictures of this long side, px."""
        return self.focal * long_side_px if self.calibrated else self.focal

    def check_size(self, size_px: tuple[int, int]) -> None:
        """Raise SpecError where a film of another shape shows another part of the picture."""
        if self.size_px is None:
            return
        shapes = [math.log(width / height) for width, height in (size_px, self.size_px)]
        if abs(shapes[0] - shapes[1]) > SAME_SHAPE_SHARE:
            raise SpecError(
                "the camera was calibrated with pictures of {}x{} px, and the film has {}x{} px, which is another part "
                "of them; calibrate with films like this one, or leave the calibration out".format(
                    *self.size_px, *size_px
                )
            )


@dataclass(frozen=True)
class Question:
    """What a film is checked against.

    Parameters
    ----------
    badge : Badge
        The claimed badge as it was issued, or any badge of the same layout.
    badge_id : str, optional
        The id that must be read, hex digits; None if no identity is claimed.
    seal : Seal, optional
        Of the identity that must be read, instead of `badge_id`, where it is kept sealed; `badge` is then a specimen.
    as_built : AsBuilt, optional
        Figures of the badge as it was measured when it was enrolled.
    as_built_at : str, optional
        Since when these are on record, UTC, ISO 8601.
    earlier : tuple of DatedFigures
        Figures that were in use before those, oldest first: a film that agrees with one of these sets agrees, whenever
        it was made.
    replaced_at : str, optional
        Since when other figures are in use, if `as_built` is an earlier set.
    barred : Revocation, optional
        Why the badge does not count; None where it does.
    provenance : Provenance
        Where the claim comes from.
    camera : KnownCamera, optional
        What is known of the film's camera; None to estimate all of it.
    track : int, optional
        The video track to judge, as `Film.described` numbers them; a film of several is inconclusive without it.
    level : {"record", "enrolled", "live"}, optional
        Least level that must be reached (`check_level`); below it the verdict is inconclusive.  None, or "record":
        figures of enrolment must agree where there are any.
    cover_share : float, optional
        Least share of the film, 0 to 1, that must be judged; with less the verdict is inconclusive.  None for
        `limits.MIN_COVER_SHARE`.
    strength : int, optional
        An acceptance needs that at most 1 in so many forgeries that know nothing of the law would look as the film does
        (`explanations.strength`); None for `limits.LEAST_STRENGTH`.
    overlap : bool
        Require that the badge passes in front of the face and obeys the law there.
    published : bool
        Judge by the published method, which is in the lab.
    enrolling : bool
        Measure the gain of the badge's sheet: accept any gain with which a badge can be enrolled.
    """

    badge: Badge
    badge_id: str | None = None
    seal: Seal | None = None
    as_built: AsBuilt | None = None
    as_built_at: str | None = None
    earlier: tuple[DatedFigures, ...] = ()
    replaced_at: str | None = None
    barred: Revocation | None = None
    provenance: Provenance = OWN_CLAIM
    camera: KnownCamera | None = None
    track: int | None = None
    level: CheckLevel | None = None
    cover_share: float | None = None
    strength: int | None = None
    overlap: bool = False
    published: bool = False
    enrolling: bool = False

    @property
    def names_someone(self) -> bool:
        """Whether an identity is claimed, in the clear or sealed."""
        return self.badge_id is not None or self.seal is not None

    @property
    def original_required(self) -> bool:
        """Whether the figures must be those of enrolment."""
        return self.as_built is not None

    def id_if_read(self, found: str | None) -> str | None:
        """The claimed identity, as far as it is known once `found` was read: a seal opens only for the right one."""
        if self.seal is None:
            return self.badge_id
        return found if found is not None and self.seal.holds(found) else None

    def by_earlier(self) -> list[Question]:
        """The question by each earlier set of figures, the newest first."""
        dates = [*(one.at for one in self.earlier[1:]), self.as_built_at] if self.earlier else []
        dated = [
            replace(self, as_built=one.as_built, as_built_at=one.at, earlier=(), replaced_at=until)
            for one, until in zip(self.earlier, dates, strict=True)
        ]
        return dated[::-1]

    def without_figures(self) -> Question:
        """The same, as if the badge was never measured: for a check that is to measure it."""
        return replace(self, as_built=None, as_built_at=None, earlier=(), enrolling=True, level=None)

    def stated(self) -> dict[str, Any]:
        """What a report says of the claim, on the word of who asked, and not of the process that read the film."""
        known, badge = self.provenance, self.badge
        return {
            "registry": known.standing.to_json() if known.standing else None,
            "claim_source": known.source,
            "badge": {"id": badge.id, "name": badge.name, "line": line_of(badge.print)},
        }
