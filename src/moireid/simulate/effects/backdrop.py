"""A virtual background: a call program cuts out what it takes for the person, and nibbles at the badge's outline."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from moireid.simulate.effects.effect import Effect, Kind, Luma, Step, Take, alone

#: Size of a bite, mm on the page, and its life, s, since masks are smoothed over time.
BITE_MM, BITE_S = 8.0, 0.3
#: Fineness of the mask on the page, px to the mm; softness of its rim in the picture, px; the grey put behind.
FINE, RIM_PX, BEHIND = 1.0, 1.5, 150
#: Frames of bites that are drawn; they begin anew after the last without a jolt.
DRAWN = 64


def nibbled(figure: float) -> Effect:
    """All but the badge replaced by an even grey, and bites of up to so many mm out of its outline."""

    def begin(take: Take) -> Step:
        x0, y0, x1, y1 = take.outline_mm
        size = round(FINE * (x1 - x0)), round(FINE * (y1 - y0))
        inside = np.pad(np.ones(size[::-1], np.uint8), 1)
        depth_mm = cv2.distanceTransform(inside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1] / FINE
        grain = take.rng.standard_normal((DRAWN, *size[::-1]))
        life = BITE_S * take.fps
        bites = gaussian_filter(grain, (life, BITE_MM * FINE / 2, BITE_MM * FINE / 2), mode="wrap")
        bites = np.clip(bites / (2 * bites.std()), 0, 1)
        to_page = np.array([[1 / FINE, 0, x0 + 0.5 / FINE], [0, 1 / FINE, y0 + 0.5 / FINE], [0, 0, 1]])

        def step(number: int, luma: Luma) -> Luma:
            mask = (depth_mm > figure * bites[number % DRAWN]).astype(np.float32)
            seen = cv2.warpPerspective(mask, take.pages[number] @ to_page, take.size)
            share = cv2.GaussianBlur(seen, (0, 0), RIM_PX)
            return np.asarray(np.rint(BEHIND + share * (luma - np.float32(BEHIND))), np.uint8)

        return step

    return alone(begin)


KINDS = (
    Kind(
        "backdrop",
        (2.0, 5.0, 10.0),
        "depth of bites out of the badge's outline by a virtual background, mm at most",
        "masks of 256 x 144 px are 5 px coarse in 720p: 5 mm at 1 m",
        nibbled,
    ),
)
