"""Film a badge with a simulated phone, true and forged, and verify both films."""

import sys
from pathlib import Path

from moireid.designer import Order, design_badge
from moireid.simulate import Build, Camera, Scene, film, motion_named
from moireid.verifier import Question, verify, write_report

#: An identity of this example alone, so that each run is alike; a badge to wear has one of `random_payload()`.
PAYLOAD = bytes.fromhex("0123456789abcdef")


def main(folder: Path) -> None:
    """Write two short films and their reports into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    badge = design_badge(Order("Ada Lovelace", lens="50lpi"), PAYLOAD)
    scene = Scene(badge, Build.typical(seed=1), Camera(width=1280, height=720, focal_px=967.0))
    motion = motion_named("sway", distance_mm=800.0, seed=1)
    for kind in (None, "frozen"):
        name = kind or "genuine"
        made = film(scene, motion, folder / f"{name}.mp4", frames=120, fps=30, forge=kind, overwrite=True)
        report = verify(made.video, Question(badge, badge.id))
        write_report(report, folder / name, overwrite=True)
        found = report.invariant
        print(f"{name}: {report.verdict}, |rho| {found.correlation:.4f}, gain {found.gain_ratio:.3f}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
