"""How exactly ink growth is read from a photograph: run `moireid lab bench ink-growth [--clips N]`.

The strip is drawn edge by edge for a growth between 0 and 90 um, and photographed by cameras that are drawn at random:
tone curves, blur, noise, uneven light, scale; some of them sharpen.  A picture is right where its error is within three
of the reader's own error bars, and inconclusive where it is not read.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from moireid.calibration.ink_reading import ink_growth
from moireid.designer.chart import design_chart
from moireid_lab.bench.fabricate.strip_photographs import any_camera, photographed_strip
from moireid_lab.bench.part import INCONCLUSIVE, RIGHT, WRONG, Asked, Part, Row, numbered

CASES = {f"{dpi} dpi, {kind}": (dpi, kind == "sharpens") for dpi in (600, 1200) for kind in ("plain", "sharpens")}
MOST_UM, BEYOND_SDS = 90.0, 3.0


def judged(job: tuple[str, int], folder: Path) -> Row:
    """One picture."""
    name, seed = job
    dpi, sharpens = CASES[name]
    chart, growth_um = design_chart(printer_dpi=dpi), float(np.random.default_rng(1000 + seed).uniform(0, MOST_UM))
    camera = replace(any_camera(seed), sharpening=0.3 if sharpens else 0.0)
    found = ink_growth([photographed_strip(chart, growth_um, camera, seed)], chart)
    if found.um is None:
        return {"kind": name, "answers": {"ink": INCONCLUSIVE}}
    error = found.um - growth_um
    answer = RIGHT if abs(error) <= BEYOND_SDS * found.sd_um else WRONG
    return {"kind": name, "answers": {"ink": answer}, "error_um": error}


def cases(asked: Asked) -> dict[str, tuple[str, int]]:
    """All pictures."""
    return numbered(list(CASES), asked.clips or 30)


QUESTIONS = {"ink": "Is the growth of ink read from a simulated photograph within three error bars?"}
PART = Part(QUESTIONS, "no film: drawn pictures", cases, judged, 4)
