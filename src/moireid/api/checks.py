"""Is the badge in a film real, and whose is it?  As `moireid verify` and `moireid identify` find it.

A film is read in a sealed process, as by the commands: one that takes over its decoder gets nothing there.  The process
is forked from a small program of its own, not from this one, so notebooks, threads and servers may call.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from moireid.api.asking import (
    AskingTerms,
    ClaimContext,
    claim_in_bundle,
    claim_of_badge,
    claim_of_name,
    people_of_bundle,
    people_of_registry,
)
from moireid.api.film_check import FilmCheck
from moireid.api.places import Place, warn_of
from moireid.attest.film_credentials import with_carried
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.reading.film_orders import IdentifyingOrder, JudgingOrder
from moireid.reading.film_reader import film_reader
from moireid.reading.film_reports import judged_film
from moireid.verifier import Claim
from moireid.verifier.camera.known_camera import KnownCamera, load_camera
from moireid.verifier.limits import LEAST_STRENGTH, MIN_COVER_SHARE
from moireid.verifier.report.report_page import Pictures
from moireid.verifier.session.check_level import CheckLevel

Progress = Callable[[int, int | None], None]


def verify(
    film: AnyPath,
    *,
    badge: Badge | AnyPath | None = None,
    claim: str | None = None,
    registry: Place = None,
    bundle: AnyPath | None = None,
    trust: str | None = None,
    focal_px: float | None = None,
    camera: KnownCamera | AnyPath | None = None,
    require_original: bool | None = None,
    cover: float = MIN_COVER_SHARE,
    level: CheckLevel = "record",
    strength: int = LEAST_STRENGTH,
    overlap: bool = False,
    track: int | None = None,
    pictures: bool = True,
    unsealed: bool = False,
    progress: Progress | None = None,
) -> FilmCheck:
    """Check a film: is the badge real, and is it the claimed one?

    Parameters
    ----------
    film : str or Path
        The film.
    badge : Badge or str or Path, optional
        The badge, or its badge.json; with a registry that holds it, the registry's name and figures count.
    claim : str, optional
        Instead of `badge`: the name or id of who wears it, looked up in the registry or bundle.
    registry : Registry or str or Path, optional
        The registry that is asked; None for the one in the user's data folder, where there is a claim and no bundle.
    bundle : str or Path, optional
        A registry's bundle that is asked instead.
    trust : str, optional
        The fingerprint of the one authority that counts.
    focal_px : float, optional
        Focal length of the film's camera, px; None if it is not known.
    camera : KnownCamera or str or Path, optional
        A calibration of the film's camera, or its file, instead of the focal length.
    require_original : bool, optional
        Reject a film whose figures differ from those of enrolment; None requires this where they are known.
    cover : float
        Least share of the film that must be judged, 0 to 1.
    level : {"record", "enrolled", "live"}
        Least level that must be reached.
    strength : int
        An acceptance needs that at most 1 in so many forgeries that know nothing of the law would look alike.
    overlap : bool
        Require that the badge passes in front of the face.
    track : int, optional
        The video track to judge, by its number in the file; a film of several is inconclusive without it.
    pictures : bool
        Draw the report's pictures and keep the signals, in about a second.
    unsealed : bool
        Read the film in this process, with all its rights.
    progress : callable, optional
        Called with frames read, and the number expected (None if the film does not say).

    Returns
    -------
    FilmCheck
        Its verdict "accept" needs both, that the fringes follow the law and that the identity is the claimed one.

    Raises
    ------
    SpecError
        Where claim and badge are both given, or neither; and for figures that are impossible.
    RegistryError
        Where the claim means no one or several people, or the registry is not as it was signed.
    MediaError
        Where the film cannot be read.

    Warns
    -----
    UserWarning
        Where the registry or bundle is asked for the first time, or cannot be remembered.

    Notes
    -----
    Convention: the registry is asked by this process, and what reads the film learns nothing but the claimed badge.
    Source: `moireid.verifier.verify`.
    """
    video = as_path(film)
    known_camera = _camera(camera, focal_px)
    claimed = _claimed(claim, badge, registry, bundle, trust)
    with film_reader([video], unsealed=unsealed) as reader, claimed as context:
        found = context.found
        wanted = Claim.of(
            found,
            focal_px=focal_px,
            camera=known_camera,
            require_original=require_original,
            cover_share=cover,
            level=level,
            strength=strength,
        )
        order = JudgingOrder(video, wanted, found.barred, overlap, pictures=pictures, track=track)
        made = judged_film(order, reader, progress or _quiet)
        document = with_carried(made.report | context.stated(), video)
        known = context.known(document, claim)
    return FilmCheck(document, known, made.pictures, made.signals)


def _claimed(
    claim: str | None, badge: Badge | AnyPath | None, registry: Place, bundle: AnyPath | None, trust: str | None
) -> AbstractContextManager[ClaimContext]:
    """Where the claimed badge is looked up.  Raises: SpecError unless there is one claim and one place."""
    if bundle is not None and (registry is not None or claim is None):
        raise SpecError("bundle replaces registry, and needs claim; leave the other one out")
    if trust is not None and registry is None and claim is None:
        raise SpecError("trust is of a registry, and none is asked with badge alone; add registry, or leave it out")
    terms = AskingTerms(trust, warn_of)
    if claim is not None and badge is None:
        return claim_of_name(claim, registry, terms) if bundle is None else claim_in_bundle(claim, bundle, terms)
    if badge is not None and claim is None:
        return claim_of_badge(badge, registry, terms)
    raise SpecError("give either claim, a name or an id, or badge, a Badge or the path of its badge.json")


def identify(
    film: AnyPath,
    *,
    registry: Place = None,
    bundle: AnyPath | None = None,
    trust: str | None = None,
    focal_px: float | None = None,
    camera: KnownCamera | AnyPath | None = None,
    track: int | None = None,
    unsealed: bool = False,
    progress: Progress | None = None,
) -> FilmCheck:
    """Find out whose badge a film shows, of all in a registry or a bundle.

    Parameters
    ----------
    film : str or Path
        The film.
    registry, bundle, trust, focal_px, camera, track, unsealed, progress
        As `verify`.

    Returns
    -------
    FilmCheck
        Its verdict is "found", "nobody" or "inconclusive"; `found_id` and `found_name` say who.

    Raises
    ------
    SpecError
        Where registry and bundle are both given.
    RegistryError
        Where the registry or bundle is not as it was signed.
    MediaError
        Where the film cannot be read.

    Notes
    -----
    Convention: "found" needs an enrolled id and fringes that follow the law.
    Source: `moireid.verifier.identify`.
    """
    video = as_path(film)
    if bundle is not None and registry is not None:
        raise SpecError("bundle replaces registry; leave one of them out")
    known_camera, terms = _camera(camera, focal_px), AskingTerms(trust, warn_of)
    people = people_of_registry(registry, terms) if bundle is None else people_of_bundle(bundle, terms)
    with film_reader([video], unsealed=unsealed) as reader, people as scope:
        order = IdentifyingOrder(video, scope.layouts, focal_px, known_camera, track)
        document, known = scope.search(order, reader, progress or _quiet)
    return FilmCheck(document, known, Pictures())


def _camera(camera: KnownCamera | AnyPath | None, focal_px: float | None) -> KnownCamera | None:
    """The calibration that was given.  Raises: SpecError where the focal length is given too."""
    if camera is not None and focal_px is not None:
        raise SpecError("camera holds the focal length; leave focal_px out")
    return camera if camera is None or isinstance(camera, KnownCamera) else load_camera(camera)


def _quiet(done: int, of: int | None) -> None:
    """Show no progress."""
