"""Table, JSON and plot of a suite."""

from __future__ import annotations

import json
import os
import platform
from pathlib import Path
from typing import Any

from moireid import __version__
from moireid.files import planned, whole_file, write_text
from moireid_lab.bench.fabricate.fabricate_suite import fabricate_plot, fabricate_table
from moireid_lab.bench.forgers.forgers_suite import forgers_plot, forgers_table
from moireid_lab.bench.identity.identity_suite import identity_plot, identity_table
from moireid_lab.bench.natural import natural_plot, natural_table
from moireid_lab.bench.published import published_plot, published_table
from moireid_lab.bench.reality import reality_plot, reality_table
from moireid_lab.bench.simulate.simulate_suite import simulate_plot, simulate_table
from moireid_lab.bench.stability import stability_plot, stability_table
from moireid_lab.bench.verify.verify_suite import verify_plot, verify_table


def outputs(folder: Path, suite: str) -> list[Path]:
    """The files that a suite writes."""
    return [folder / f"{suite}.json", folder / f"{suite}.svg"]


def write(folder: Path, result: dict[str, Any], *, overwrite: bool) -> list[Path]:
    """Write the suite's JSON, with machine and versions, and its plot; whole or not at all."""
    data, plot = outputs(folder, result["suite"])
    planned([data, plot], overwrite=overwrite)
    machine = {"processor": platform.machine(), "cores": os.cpu_count(), "python": platform.python_version()}
    document = {"moireid": __version__, "machine": machine} | result
    write_text(data, json.dumps(document, indent=1) + "\n")
    with whole_file(plot) as temporary:
        PLOTS[result["suite"]](result).savefig(temporary, format="svg", metadata={"Date": None})
    return [data, plot]


TABLES = {
    "identity": identity_table,
    "stability": stability_table,
    "fabricate": fabricate_table,
    "simulate": simulate_table,
    "verify": verify_table,
    "forgers": forgers_table,
    "reality": reality_table,
    "natural": natural_table,
    "published": published_table,
}
PLOTS = {
    "identity": identity_plot,
    "stability": stability_plot,
    "fabricate": fabricate_plot,
    "simulate": simulate_plot,
    "verify": verify_plot,
    "forgers": forgers_plot,
    "reality": reality_plot,
    "natural": natural_plot,
    "published": published_plot,
}
