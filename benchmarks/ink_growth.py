"""How exactly ink growth is read from a photograph: run `moireid lab bench ink-growth [--clips N]`.

The strip is drawn edge by edge for a growth between 0 and 90 um, and photographed by cameras that are drawn at random:
tone curves, blur, noise, uneven light, scale; a third of them sharpen.  One row a printer and kind of camera: pictures
that are read; root mean square of the error, um; the greatest error; root mean square of it in the reader's own error
bars; share beyond three of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from moireid.calibration.ink_reading import ink_growth
from moireid.designer.chart import design_chart
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.fabricate.strip_photographs import any_camera, photographed_strip

CASES = {f"{dpi} dpi, {kind}": (dpi, kind == "sharpens") for dpi in (600, 1200) for kind in ("plain", "sharpens")}
MOST_UM, BEYOND_SDS = 90.0, 3.0


def rows_of(wish: Wish) -> Iterator[Row]:
    """One row a case."""
    for name in wish.chosen(CASES):
        dpi, sharpens = CASES[name]
        chart, errors, bars = design_chart(printer_dpi=dpi), [], []
        seeds = wish.seeds(60, 8)
        for seed in seeds:
            growth_um = float(np.random.default_rng(1000 + seed).uniform(0, MOST_UM))
            camera = replace(any_camera(seed), sharpening=0.3 if sharpens else 0.0)
            found = ink_growth([photographed_strip(chart, growth_um, camera, seed)], chart)
            if found.um is not None:
                errors.append(found.um - growth_um)
                bars.append(found.sd_um)
        off = np.array(errors) / np.array(bars)
        yield {
            "case": name,
            "pictures": len(seeds),
            "read": len(errors),
            "rms um": float(np.sqrt(np.mean(np.square(errors)))) if errors else None,
            "worst um": float(np.abs(errors).max()) if errors else None,
            "in bars": float(np.sqrt(np.mean(off**2))) if errors else None,
            "beyond 3": float(np.mean(np.abs(off) > BEYOND_SDS)) if errors else None,
        }


COLUMNS = {
    "case": "<22",
    "pictures": ">9",
    "read": ">5",
    "rms um": ">7.1f",
    "worst um": ">9.1f",
    "in bars": ">8.2f",
    "beyond 3": ">9.3f",
}
BENCH = Bench(rows_of, COLUMNS)
