"""The phase law by hand: beat, effective gap, and how far the fringes move as the camera does."""

import math
import sys
from pathlib import Path

from moireid.lenticule import view_law
from moireid.optics import beat_frequency_per_mm, beat_period_mm, parallax_slope_rad, paraxial_effective_gap_mm
from moireid.profiles import lens_named


def main(folder: Path) -> None:
    """Print the figures of the published prototype; `folder` is not used."""
    lens, rear_pitch_mm = lens_named("50lpi"), 0.52
    law = view_law(lens, rear_pitch_mm)
    gap_mm = law.effective_gap_mm(rear_pitch_mm)
    far = beat_frequency_per_mm(lens.pitch_mm, rear_pitch_mm)
    near = beat_frequency_per_mm(lens.pitch_mm, rear_pitch_mm, effective_gap_mm=gap_mm, distance_mm=1000.0)
    print(f"beat period far away {float(beat_period_mm(far)):.2f} mm, at 1 m {float(beat_period_mm(near)):.2f} mm")
    print(f"effective gap {gap_mm:.3f} mm, g/n {paraxial_effective_gap_mm(lens):.3f} mm")
    print(f"slope {parallax_slope_rad(gap_mm, rear_pitch_mm):.2f} rad per unit of Cx/Cz")
    for degrees in (10, 30, 45, 60):
        tangent = math.tan(math.radians(degrees))
        straight = parallax_slope_rad(gap_mm, rear_pitch_mm) * tangent
        print(f"at {degrees} degrees: {float(law.phase_rad(tangent)):6.2f} rad, a straight law {straight:6.2f}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
