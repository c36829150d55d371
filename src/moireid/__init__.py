"""moireid: print a moiré badge, film it, and check that its fringes obey the optics and whose badge it is.

    import moireid as mo

    badge = mo.design("Ada Lovelace")
    mo.print_badge(badge, "ada")
    mo.simulate(badge, "film.mp4")
    check = mo.verify("film.mp4", badge=badge)

Each of these names is loaded when it is first used.  The rooms below have the rest.

badge.py         the frozen Badge and its JSON           errors.py     the error tree
layers.py        its lens and its printed gratings       models.py     files into models, and what is wrong with them
profiles.py      lens sheets and printers by name        files.py      files written whole or not at all
sheets.py        lens sheets as they are sold            lazy.py       packages that load modules on demand
optics.py        the phase law in closed form            extras.py     the sentence for a missing optional package
lenticule.py     ray tracing, and the law's table        sandbox/      work in a process without rights
frames.py        the frame of a grating                  idcodes/      payload <-> line spacing
dots.py          lines on a printer's dots               artwork/      what a badge's page looks like
smooth_lines.py  lines that bend from cell to cell       ink_strip.py  a strip that shows how ink grows
fiducials.py     four squares, or a thin coded frame     designer/     name, lens, printer, range -> Badge
names.py         invisible letters; lines of namesakes   fabrication/  Badge -> PDF and mount
asbuilt.py       figures of one built badge              simulate/     Badge -> film, true or forged
provenance.py    where a claim comes from                verifier/     film -> report and verdict
question.py      what a film is checked against          scheduler.py  how a Dask scheduler is reached
materials.py     the table of what a badge is built of
result_cache.py  rows of figures kept in a file          reading/      films read in a sealed process
arguments.py     what public functions are given, checked
json_schema.py   documents held against a JSON Schema
user_settings.py a user's folders, and the nearest word
camera_chart.py  the chart to calibrate a camera with    registry/     who was issued which badge
calibration/     a sheet or a camera, from pictures      attest/       verdicts signed, and checked by others
cli/             the two programs                        issuing.py    an order -> a badge that can be made
api/             what `import moireid as mo` offers      enrolment.py  measured figures into a registry
version.py       the version of the packages             shopping.py   a format or a badge -> what to buy for it
                                                         people.py     a list of people -> the badge of each
"""

from moireid.lazy import lazy
from moireid.version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from moireid.api.checks import identify, verify
    from moireid.api.film_check import FilmCheck
    from moireid.api.making import design, print_badge
    from moireid.api.places import Registry
    from moireid.asbuilt import AsBuilt
    from moireid.badge import Badge, load_badge
    from moireid.designer.order import Order
    from moireid.errors import (
        CodeError,
        DesignError,
        FabricationError,
        MediaError,
        MissingExtraError,
        MoireIdError,
        RegistryError,
        SpecError,
    )
    from moireid.fabrication.solid_parts import mount_solids
    from moireid.simulate.film_badge import simulate

__all__ = [
    "AsBuilt",
    "Badge",
    "CodeError",
    "DesignError",
    "FabricationError",
    "FilmCheck",
    "MediaError",
    "MissingExtraError",
    "MoireIdError",
    "Order",
    "Registry",
    "RegistryError",
    "SpecError",
    "__version__",
    "design",
    "identify",
    "load_badge",
    "mount_solids",
    "print_badge",
    "simulate",
    "verify",
]

_ERRORS = (
    *("CodeError", "DesignError", "FabricationError", "MediaError"),
    *("MissingExtraError", "MoireIdError", "RegistryError", "SpecError"),
)

__getattr__ = lazy(
    __name__,
    {
        **dict.fromkeys(_ERRORS, "errors"),
        **dict.fromkeys(("identify", "verify"), "api.checks"),
        **dict.fromkeys(("design", "print_badge"), "api.making"),
        **dict.fromkeys(("Badge", "load_badge"), "badge"),
        "AsBuilt": "asbuilt",
        "FilmCheck": "api.film_check",
        "Order": "designer.order",
        "Registry": "api.places",
        "mount_solids": "fabrication.solid_parts",
        # The package, which can be called.
        "simulate": "",
    },
)


def __dir__() -> list[str]:
    return __all__
