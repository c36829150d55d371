"""The suites of `moireid bench`, each with its table and plot, and the files that a suite writes."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from moireid import __version__
from moireid.files import planned, whole_file, write_text
from moireid_lab.bench import natural, published, reality, stability
from moireid_lab.bench.bench_frame import Wish
from moireid_lab.bench.fabricate import fabricate_suite
from moireid_lab.bench.forgers import forgers_suite
from moireid_lab.bench.identity import identity_suite
from moireid_lab.bench.simulate import simulate_suite
from moireid_lab.bench.verify import verify_suite

Document = dict[str, Any]


class Suite(NamedTuple):
    """What measures, what shows the result as text, and what draws it."""

    run: Callable[[Wish], Document]
    table: Callable[[Document], str]
    plot: Callable[[Document], Any]


SUITES = {
    "identity": Suite(identity_suite.run, identity_suite.identity_table, identity_suite.identity_plot),
    "stability": Suite(stability.run, stability.stability_table, stability.stability_plot),
    "fabricate": Suite(fabricate_suite.run, fabricate_suite.fabricate_table, fabricate_suite.fabricate_plot),
    "simulate": Suite(simulate_suite.run, simulate_suite.simulate_table, simulate_suite.simulate_plot),
    "verify": Suite(verify_suite.run, verify_suite.verify_table, verify_suite.verify_plot),
    "forgers": Suite(forgers_suite.run, forgers_suite.forgers_table, forgers_suite.forgers_plot),
    "reality": Suite(reality.run, reality.reality_table, reality.reality_plot),
    "natural": Suite(natural.run, natural.natural_table, natural.natural_plot),
    "published": Suite(published.run, published.published_table, published.published_plot),
}


def outputs(folder: Path, suite: str) -> list[Path]:
    """The files that a suite writes."""
    return [folder / f"{suite}.json", folder / f"{suite}.svg"]


def write(folder: Path, result: Document, *, overwrite: bool) -> list[Path]:
    """Write the suite's JSON, with machine and versions, and its plot; whole or not at all."""
    data, plot = outputs(folder, result["suite"])
    planned([data, plot], overwrite=overwrite)
    machine = {"processor": platform.machine(), "cores": os.cpu_count(), "python": platform.python_version()}
    document = {"moireid": __version__, "machine": machine} | result
    write_text(data, json.dumps(document, indent=1) + "\n")
    with whole_file(plot) as temporary:
        SUITES[result["suite"]].plot(result).savefig(temporary, format="svg", metadata={"Date": None})
    return [data, plot]
