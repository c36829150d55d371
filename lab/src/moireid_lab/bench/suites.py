"""The benches of `moireid lab bench` by suite, each with the module in which it is `BENCH`.

Modules without a package are scripts in `benchmarks/` of the repository: they film by the outside tracer there, or by
`true_films`, or use the films of the tests.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid_lab.bench.part import Part

#: By suite: its benches, each by the name by which it also runs alone.  A module has a `PART` of the scoreboard, or a
#: `BENCH` that prints figures alone.
SUITES: dict[str, dict[str, str]] = {
    "films": {
        "outside": "outside_films",
        "natural": "natural_films",
        "reality": "moireid_lab.bench.reality",
        "stability": "moireid_lab.bench.stability",
        "builds": "builds",
        "lenses": "any_lens",
        "half-real": "half_real",
        "small-pages": "small_pages",
        "kept": "kept_signals",
        "priors": "priors",
    },
    "attacks": {
        "forgers": "moireid_lab.bench.forgers.forgers_suite",
        "replayed": "replayed",
        "morphed": "morphed_photographs",
        "turned": "turned_photographs",
        "laid-over": "laid_over",
        "live": "live_replays",
        "live-enrolment": "live_enrolment",
    },
    "identity": {"identity": "moireid_lab.bench.identity.identity_suite"},
    "cost": {
        "cost": "moireid_lab.bench.cost",
        "registry": "registry_scale",
        "simulate": "moireid_lab.bench.simulate.simulate_suite",
    },
    "pages": {
        "ink-growth": "ink_growth",
        "fabricate": "moireid_lab.bench.fabricate.fabricate_suite",
        "mounts": "mounts",
    },
    "paper": {"paper": "moireid_lab.bench.paper"},
}
#: Every bench by name.
BENCHES = {name: module for suite in SUITES.values() for name, module in suite.items()}
#: Those that print figures alone.
FIGURES_ALONE = ("simulate", "mounts")
PARTS = tuple(name for name in BENCHES if name not in FIGURES_ALONE)
SCRIPTS = Path(__file__).parents[4] / "benchmarks"


def names_of(suite: str) -> list[str]:
    """The benches of a suite, or the one of that name."""
    return list(SUITES.get(suite, (suite,)))


def module_of(name: str) -> str:
    """The module of a bench, which this process and those that it starts can import.

    Raises: SpecError where a script's folder is not there.
    """
    module = BENCHES[name]
    if "." not in module:
        if not SCRIPTS.is_dir():
            raise SpecError(f"{name} films by scripts of the repository, which are not installed; run it in a checkout")
        if str(SCRIPTS) not in sys.path:
            sys.path.insert(0, str(SCRIPTS))
            os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(SCRIPTS), os.environ.get("PYTHONPATH")]))
    importlib.import_module(module)
    return module


def part_of(name: str) -> Part:
    """A part of the scoreboard.  Raises: as `module_of`."""
    return importlib.import_module(module_of(name)).PART  # type: ignore[no-any-return]
