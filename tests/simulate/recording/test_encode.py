"""Codecs and recipes, and films that end before their time.  Each test names what it would catch."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import av
import numpy as np
import pytest

from moireid.badge import Badge
from moireid.simulate.effects.effect import Effect
from moireid.simulate.filming import FilmReport, film, truth_path
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.encode import FilmWriter, Pass, Recipe
from moireid.simulate.scene import Build, Camera, Scene

SMALL = Camera(width=640, height=360, focal_px=483.0)
FPS = 25.0


def shoot(badge: Badge, path: Path, *, frames: int = 12, camera: Camera = SMALL, **options) -> FilmReport:
    motion = motion_named("sway", distance_mm=600.0, seed=3)
    return film(Scene(badge, Build(), camera), motion, path, frames=frames, fps=FPS, **options)


def read(path: Path) -> tuple[str, np.ndarray, np.ndarray]:
    """Codec, times and pictures of a film."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        frames = [(float(frame.time), frame.to_ndarray(format="gray")) for frame in container.decode(stream)]
        name = stream.codec_context.codec.canonical_name
    return name, np.array([clock for clock, _ in frames]), np.stack([picture for _, picture in frames])


def truth_of(path: Path) -> list[dict[str, str]]:
    with truth_path(path).open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def badge_file(badge: Badge, folder: Path) -> Path:
    path = folder / "badge.json"
    path.write_text(badge.to_json(), encoding="utf-8")
    return path


# Codecs.


@pytest.mark.slow
@pytest.mark.parametrize(("codec", "name"), [("h264", "h264"), ("h265", "hevc")])
def test_every_codec_shows_the_same_film(prototype, tmp_path, codec, name):
    """Catches: a codec that is offered and not used; another brightness; frames lost at the end of a deep encoder."""
    shoot(prototype, tmp_path / "best.mp4", crf=1)
    shoot(prototype, tmp_path / "a.mp4", effects=[Effect(recipe=lambda recipe: Recipe((Pass(codec),)))])
    found, times, pictures = read(tmp_path / "a.mp4")
    assert found == name and times == pytest.approx(np.arange(12) / FPS, abs=1e-4)
    best = read(tmp_path / "best.mp4")[2].astype(float)
    assert abs((pictures - best).mean()) < 1.0 and np.sqrt(((pictures - best) ** 2).mean()) < 6.0
    assert abs(float(truth_of(tmp_path / "a.mp4")[-1]["time_s"]) - times[-1]) < 1e-4


# Recipes.


def test_a_low_rate_is_kept(tmp_path):
    """Catches: kbps taken for bits or bytes; a rate next to a quality, which then rules."""
    sizes = {}
    for kbps in (200, 800):
        path = tmp_path / f"{kbps}.mp4"
        with FilmWriter(path, "a", (640, 360), 25.0, Recipe((Pass(kbps=kbps),))) as writer:
            rng = np.random.default_rng(1)
            for k in range(75):
                writer.write(rng.integers(90, 160, (360, 640), dtype=np.uint8), k)
        sizes[kbps] = path.stat().st_size * 8 / 3 / 1000
    assert sizes[200] < 0.5 * sizes[800] and 500 < sizes[800] < 1400


def test_two_encodings_lose_more_than_one_and_no_frame(prototype, tmp_path):
    """Catches: a second pass that is left out; frames that stay in the first encoder; their order or times changed."""
    shoot(prototype, tmp_path / "best.mp4", crf=1)
    best = read(tmp_path / "best.mp4")[2].astype(float)
    errors = []
    for passes in ((Pass(crf=34),), (Pass(crf=34), Pass(crf=34))):
        path = tmp_path / f"{len(passes)}.mp4"
        with FilmWriter(path, "a", (640, 360), FPS, Recipe(passes)) as writer:
            for k, picture in enumerate(best.astype(np.uint8)):
                writer.write(picture, k)
        _, times, pictures = read(path)
        assert times == pytest.approx(np.arange(12) / FPS, abs=1e-4)
        errors.append(np.sqrt(((pictures - best) ** 2).mean(axis=(1, 2))))
    assert errors[1].mean() > 1.05 * errors[0].mean()
    # A frame in another's place would be off by the 5 px that the badge moves in a frame.
    assert np.all(errors[1] < 2.5 * errors[0])


@pytest.mark.slow
def test_dropped_frames_leave_gaps_and_the_truth_fits_the_others(prototype, tmp_path):
    """Catches: times closed up after a loss; a truth of frames that are not in the file; one row too many."""
    report = shoot(prototype, tmp_path / "a.mp4", recipe="vfr", frames=60, seed=4)
    _, times, pictures = read(tmp_path / "a.mp4")
    rows = truth_of(tmp_path / "a.mp4")
    assert 35 <= len(times) == len(rows) == len(pictures) == report.frames <= 55
    assert [int(row["frame"]) for row in rows] == list(range(len(rows)))
    assert times == pytest.approx([float(row["time_s"]) for row in rows], abs=1e-4)
    steps = np.rint(np.diff(times) * FPS)
    assert set(steps) >= {1.0, 2.0}
    poses = motion_named("sway", distance_mm=600.0, seed=3)(times)
    assert np.allclose([float(row["camera_x_mm"]) for row in rows], poses.camera_mm[:, 0], atol=0.1)
    # What is in the file at a time is what a film without losses shows at that time.
    shoot(prototype, tmp_path / "b.mp4", frames=60, seed=4)
    whole = read(tmp_path / "b.mp4")[2][np.rint(times * FPS).astype(int)].astype(float)
    assert np.abs(pictures - whole).mean(axis=(1, 2)).max() < 3.0


# Films that end before their time, and long ones.


@pytest.mark.slow
def test_an_interrupt_leaves_no_file(prototype, tmp_path):
    """Catches: Ctrl-C that leaves half a film, its truth or a temporary file; a traceback; a run that goes on."""
    video, out = badge_file(prototype, tmp_path), tmp_path / "out"
    out.mkdir()
    code = "import sys; from moireid.cli.main import main; sys.argv[0] = 'moireid'; main()"
    arguments = ["simulate", str(video), "--out", str(out / "a.mp4"), "--frames", "100000", "--distance", "1"]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    try:
        limit = time.monotonic() + 120
        # The film has begun when its truth has rows, which are written out by the block.
        while not any(path.stat().st_size > 0 for path in out.glob(".a*")) and time.monotonic() < limit:
            assert process.poll() is None, process.communicate()
            time.sleep(0.1)
        assert list(out.glob(".a*")) and not (out / "a.mp4").exists()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=120)
    finally:
        process.kill()
    assert process.returncode == 130 and "Traceback" not in said and "interrupted" in said
    assert list(out.iterdir()) == []
