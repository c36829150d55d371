"""Films of a badge, true or forged, with their ground truth; called, it films one: `mo.simulate(badge, "film.mp4")`.

scene.py       one description of badge as built, camera and light, for every renderer
build.py       how a built badge differs from its design; builds and sheets by name
flaw_table.py  every flaw of a build: unit, range and meaning
motion.py      where the camera is: named motions, two measured ones, CSV files
turns.py       rotations and splines
phone_walk.py  a phone's measured walk, changed to a walk around the badge
cameras.py     cameras: lens and its distortion, shutter, exposure; some by name
light.py       a disc of light before an even sky, and the bands into which the lenses focus it
analytic/      rays traced in closed form through the true lenses
mitsuba/       the same scene as geometry for Mitsuba 3
recording/     what a camera and a codec make of a picture
settings/      where the badge is filmed: desk, worn, lectern, call
forgeries/     what a forged film shows
effects/       what phones, editors, calls and services do to a film
truth.py       the ground truth of a film, as CSV; seconds by stage
compiled.py    numba's compiler, with types
shots.py       the camera's pictures, one by one, with their effects
filming.py     the whole film: frames, file and truth
film_badge.py  a film by names
"""

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

from moireid.lazy import from_room, lazy

if TYPE_CHECKING:
    from moireid.simulate.build import Build as Build
    from moireid.simulate.cameras import Camera as Camera
    from moireid.simulate.cameras import camera_named as camera_named
    from moireid.simulate.filming import FilmReport as FilmReport
    from moireid.simulate.filming import film as film
    from moireid.simulate.filming import truth_path as truth_path
    from moireid.simulate.light import DiscLight as DiscLight
    from moireid.simulate.light import light_named as light_named
    from moireid.simulate.motion import Motion as Motion
    from moireid.simulate.motion import Poses as Poses
    from moireid.simulate.motion import motion_named as motion_named
    from moireid.simulate.scene import Scene as Scene

HOMES = {
    "Build": "build",
    "Camera": "cameras",
    "DiscLight": "light",
    "FilmReport": "filming",
    "Motion": "motion",
    "Poses": "motion",
    "Scene": "scene",
    "camera_named": "cameras",
    "film": "filming",
    "light_named": "light",
    "motion_named": "motion",
    "truth_path": "filming",
}
__all__ = [*HOMES]
__getattr__ = lazy(__name__, HOMES)


class _CallableRoom(ModuleType):
    # This package is the function `film_badge.simulate` where it is called or explained: both have one name.
    def __call__(self, *args: Any, **wished: Any) -> Any:
        return from_room(f"{__name__}.film_badge", "simulate")(*args, **wished)

    @property
    def __signature__(self) -> Any:
        return from_room("inspect", "signature")(from_room(f"{__name__}.film_badge", "simulate"))

    @property
    def __doc__(self) -> Any:  # type: ignore[override]
        return from_room(f"{__name__}.film_badge", "simulate").__doc__


sys.modules[__name__].__class__ = _CallableRoom
