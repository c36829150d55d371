"""Is the badge in a film real, and whose is it?  As `moireid verify` and `moireid identify` find it.

A film is read in a sealed process, as by the commands: one that takes over its decoder gets nothing there.  The process
is forked from a small program of its own, not from this one, so notebooks, threads and servers may call.
"""

from __future__ import annotations

from dataclasses import replace

from moireid.api.asking import asked, claim_context, search
from moireid.api.film_check import FilmCheck, judge
from moireid.api.places import Place, warn_of
from moireid.arguments import checked
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.question import CheckLevel, KnownCamera
from moireid.reading.film_orders import Progress
from moireid.reading.film_reader import film_reader
from moireid.verifier.camera.known_camera import load_camera
from moireid.verifier.report.report_page import Pictures

#: Focal lengths of cameras, least and most, px.
FOCAL_PX = (50, 100_000)


@checked(cover=(0, 1))
def verify(
    film: AnyPath,
    *,
    badge: Badge | AnyPath | None = None,
    claim: str | None = None,
    registry: Place = None,
    bundle: AnyPath | None = None,
    trust: str | None = None,
    camera: KnownCamera | AnyPath | float | None = None,
    cover: float | None = None,
    level: CheckLevel | None = None,
    strength: int | None = None,
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
    camera : KnownCamera or str or Path or float, optional
        A calibration of the film's camera, its file, or the focal length alone, px; None if nothing is known.
    cover : float, optional
        Least share of the film that must be judged, 0 to 1; None for a half.
    level : {"record", "enrolled", "live"}, optional
        Least level that must be reached; None, or "record": figures
        of enrolment must agree where there are any.
    strength : int, optional
        An acceptance needs that at most 1 in so many forgeries that know nothing of the law would look alike; None
        for 50.
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
    video, known = as_path(film), _camera(camera)
    claimed = claim_context(claim, badge, registry, bundle, trust, warn_of)
    with film_reader([video], unsealed=unsealed) as reader, claimed as (found, look_up):
        question = replace(
            found,
            camera=known,
            track=track,
            level=level,
            cover_share=cover,
            strength=strength,
            overlap=overlap,
        )
        return judge(video, question, look_up, reader, progress or _quiet, pictures=pictures)


@checked()
def identify(
    film: AnyPath,
    *,
    registry: Place = None,
    bundle: AnyPath | None = None,
    trust: str | None = None,
    camera: KnownCamera | AnyPath | float | None = None,
    track: int | None = None,
    unsealed: bool = False,
    progress: Progress | None = None,
) -> FilmCheck:
    """Find out whose badge a film shows, of all in a registry or a bundle.

    Parameters
    ----------
    film : str or Path
        The film.
    registry, bundle, trust, camera, track, unsealed, progress
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
    known, people = _camera(camera), asked(registry, bundle, trust, warn_of)
    with film_reader([video], unsealed=unsealed) as reader, people as (held, standing):
        return FilmCheck(*search(held, standing, video, known, track, reader, progress or _quiet), Pictures())


def _camera(camera: KnownCamera | AnyPath | float | None) -> KnownCamera | None:
    """What is known of a camera; a number is its focal length, px."""
    if isinstance(camera, int | float):
        if not FOCAL_PX[0] <= camera <= FOCAL_PX[1]:
            raise SpecError(f"camera={camera:g} is no focal length; give {FOCAL_PX[0]} to {FOCAL_PX[1]} px")
        return KnownCamera(camera)
    return camera if camera is None or isinstance(camera, KnownCamera) else load_camera(camera)


def _quiet(done: int, of: int | None) -> None:
    """Show no progress."""
