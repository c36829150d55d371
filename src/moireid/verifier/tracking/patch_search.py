"""Where the patches of a page are around an expected place: each patch is correlated with the picture at every shift.

All patches together give one shift of the page.  Squares that are each seen clearly give the page by their middles: so
it may have turned, and a page may begin from two markers, or one, whose corners are off by half a pixel.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.verifier.kernel.page import correlations
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.print_template import Template
from moireid.verifier.tracking.registration import PageRegistrar, Registration
from moireid.verifier.tracking.search_work import MATCHED_NS, SOUGHT_NS

Array = NDArray[np.float64]
#: Prints are correlated with so many blocks of samples a module at least, and as so many across and down at least.
MODULE_BLOCKS, LEAST_BLOCKS = 2.0, 4
#: Correlation from which a square is taken for seen where it is by itself.
SEEN = 0.65
#: The rest of a page is this near to where one or two of its markers put it, modules, if these are smaller than so many
#: px; larger ones put it near enough for registration.
REACH_MODULES, SMALL_PX = 8.0, 4.0


def registered(registrar: PageRegistrar, picture: Picture, start: Array, template: Template) -> Registration | None:
    """As `PageRegistrar.register`; where not all of the page is visible from that start, its parts are sought too."""
    found = registrar.register(picture, start, template)
    small = template.px_per_mm * registrar.printer.module_mm < SMALL_PX
    if not small or (found is not None and found.vague == (1.0, 1.0)):
        return found
    score, place = sought(registrar, picture.in_light, start, template, REACH_MODULES)
    other = registrar.register(picture, place, template) if score >= SEEN else None
    return other if found is None or (other is not None and other.vague < found.vague) else found


def sought(
    registrar: PageRegistrar, light: Picture, expected: Array, template: Template, reach_modules: float
) -> tuple[float, Array]:
    """Mean correlation of the patches where they fit best, and the homography there.

    Source: of blocks of samples of which two show a module, since registration finds the rest of the way.
    """
    printer, samples, pitch = registrar.printer, template.samples, template.drawing.pitch_mm
    module, least = printer.module_mm / pitch, min(map(min, samples.shapes))
    fewer = max(1, min(int(module / MODULE_BLOCKS), least // LEAST_BLOCKS))
    reach = math.ceil(reach_modules * module / fewer)
    each = np.zeros((len(samples.parts), 2 * reach + 1, 2 * reach + 1), np.float32)
    for here, shape, own in zip(samples.parts, samples.shapes, each, strict=True):
        # A patch's samples run along rows from its top left one.
        x, y = (samples.points[here.start] * printer.extent + printer.middle).tolist()
        to_page = np.array([[pitch, 0, x], [0, pitch, y], [0, 0, 1.0]])
        correlations(light.struct, expected @ to_page, template.values[here].reshape(shape), fewer, reach, own)
        blocks = shape[0] // fewer * (shape[1] // fewer)
        registrar.work_ns += MATCHED_NS * own.size * blocks
        registrar.work_ns += SOUGHT_NS * (blocks + 2 * reach * sum(shape) // fewer + 4 * reach**2)
    step, total, side = fewer * pitch, each.mean(axis=0), 2 * reach + 1
    best, squares = each.max(axis=(1, 2)), all(patch.side is None for patch in printer.patches)
    # One shift says more of a smeared page, whose squares are each found to half a module.
    if squares and total.max() < SEEN <= best.min():
        rows, columns = np.divmod(each.reshape(len(each), -1).argmax(axis=1), side)
        moved = printer.centers_mm + np.column_stack([columns - reach, rows - reach]) * step
        seen = cv2.perspectiveTransform(moved.reshape(-1, 1, 2), expected)
        page, _ = cv2.findHomography(printer.centers_mm, seen, 0)
        if page is not None and np.all(np.isfinite(page)):
            return float(best.mean()), np.asarray(page)
    row, column = divmod(int(total.argmax()), side)
    place = expected @ np.array([[1, 0, (column - reach) * step], [0, 1, (row - reach) * step], [0, 0, 1.0]])
    return float(total[row, column]), np.asarray(place / place[2, 2])
