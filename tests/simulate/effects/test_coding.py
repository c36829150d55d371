"""Files of high dynamic range, of calls, and with a flag.  Each test names what it would catch."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from moireid.badge import Badge
from moireid.simulate.cameras import Camera
from moireid.simulate.effects.table import effect_named
from moireid.simulate.film_badge import simulate
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.encode import FilmWriter, Pass, Recipe
from moireid.simulate.recording.sensor import hybrid_log_gamma, perceptual_quantiser
from moireid.simulate.scene import Build, Scene


def shoot(badge: Badge, path: Path, *effects: str, frames: int = 6, size: tuple[int, int] = (480, 272)) -> Path:
    scene = Scene(badge, Build(), Camera(*size, 363.0 * size[0] / 480))
    motion = motion_named("linear", distance_mm=600.0, seed=2)
    film(scene, motion, path, frames=frames, fps=30.0, effects=[effect_named(one) for one in effects])
    return path


def test_the_curves_are_those_of_the_standards():
    """Catches: a constant mistyped; a scale of scene light.  Figures of ITU-R BT.2408: 203 cd/m2 is 75 % and 58 %."""
    assert hybrid_log_gamma(np.array([0.0, 1 / 12, 0.265, 1.0])) == pytest.approx([0, 0.5, 0.75, 1.0], abs=2e-3)
    assert perceptual_quantiser(np.array([0.0, 100.0, 203.0, 10000.0])) == pytest.approx([0, 0.508, 0.58, 1], abs=2e-3)


@pytest.mark.parametrize(("name", "code"), [("hlg", 18), ("pq", 16)])
def test_a_film_of_high_dynamic_range_has_ten_bits_and_says_so(prototype, tmp_path, name, code):
    """Catches: a flag without the bits; 10 bits filled as 8; a curve that is not used."""
    with av.open(str(shoot(prototype, tmp_path / "a.mp4", name))) as container:
        context = container.streams.video[0].codec_context
        frames = [frame.to_ndarray(format="gray10le") for frame in container.decode(video=0)]
        assert context.pix_fmt == "yuv420p10le" and context.color_trc == code and context.color_primaries == 9
    assert len(frames) == 6 and np.percentile(frames[0], 99.9) > 300


def test_paper_is_as_bright_in_the_file_as_the_standard_says(tmp_path):
    """Catches: counts from the wrong end; video range applied twice.  White: 64 + 876 * 0.75."""
    way = Recipe((Pass("h265", crf=10, transfer="hlg"),))
    with FilmWriter(tmp_path / "a.mp4", "a.mp4", (320, 180), 30.0, way) as writer:
        for k in range(3):
            writer.write(np.full((180, 320), 255, np.uint8), k)
    with av.open(str(tmp_path / "a.mp4")) as container:
        frame = next(container.decode(video=0))
        plane = np.frombuffer(frame.planes[0], np.uint16).reshape(frame.planes[0].height, -1)[:, :320]
    assert plane.mean() == pytest.approx(64 + 876 * 0.75, abs=4)


def test_a_call_changes_its_sharpness_and_keeps_its_size(tmp_path):
    """Catches: frames lost where the size changes; a file that changes its size; a spell that never ends."""
    noise = np.random.default_rng(1).integers(0, 256, (360, 640)).astype(np.uint8)
    way = Recipe((Pass(kbps=20000, turns=(360, 90)), Pass(crf=10)))
    with FilmWriter(tmp_path / "a.mp4", "a.mp4", (640, 360), 10.0, way) as writer:
        for k in range(70):
            writer.write(noise, k)
    with av.open(str(tmp_path / "a.mp4")) as container:
        frames = [(float(frame.time), frame.to_ndarray(format="gray")) for frame in container.decode(video=0)]
    assert [time for time, _ in frames] == pytest.approx(np.arange(70) / 10, abs=1e-3)
    assert {picture.shape for _, picture in frames} == {(360, 640)}
    spread = np.array([picture.std() for _, picture in frames])
    assert np.array_equal(spread > 30, [k // 30 % 2 == 0 for k in range(70)])


# What a wish names.


def test_a_film_takes_the_effects_that_are_wished(prototype, tmp_path):
    """Catches: effects of a wish that are dropped, or taken in another order."""
    wish = {"motion": "linear", "frames": 4, "fps": 24.0, "camera": "webcam", "effects": ("tile", "crop:light")}
    report = simulate(prototype, tmp_path / "a.mp4", **wish)
    assert report.size == (1728, 1080)
    with av.open(str(report.video)) as container:
        assert container.streams.video[0].average_rate == 24
