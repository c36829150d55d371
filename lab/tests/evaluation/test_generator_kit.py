"""The kit for a user of a video generator.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import csv
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from moireid.cli.main import moireid
from moireid_lab.commands.generator_cmd import FORMATS as OFFERED
from moireid_lab.evaluation.generator_kit import FORMATS, PROMPTS, fitted
from moireid_lab.evaluation.manifest import read_manifest


def ran(*words: str | Path) -> Result:
    return CliRunner().invoke(moireid, ["lab", "generator-kit", *map(str, words)])


@pytest.fixture
def kit(tmp_path: Path, films: Path) -> Path:
    """A kit of one genuine film; the list names a forged one too."""
    rows = [
        f"{films}/genuine_1.0m.mp4,genuine,{films}/badge.json,desk",
        f"{films}/forged_drift_1.0m.mp4,forged:drift,{films}/badge.json,desk",
    ]
    (tmp_path / "list.csv").write_text("\n".join(["video,label,claim,group", *rows]), encoding="utf-8")
    made = ran("cut", tmp_path / "list.csv", "--out", tmp_path / "kit")
    assert made.exit_code == 0, made.output
    return tmp_path / "kit"


def table_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_kit_holds_a_frame_for_each_size_and_a_line_for_each_clip(kit: Path):
    """Catches: sizes turned round, forged films cut too, a prompt that is asked for and not written."""
    assert tuple(FORMATS) == OFFERED
    frames = {path.name: cv2.imread(str(path)).shape for path in (kit / "frames").iterdir()}
    assert frames == {f"0002-{name}.png": (high, wide, 3) for name, (wide, high, _) in FORMATS.items()}
    prompts = {row["prompt"]: row["paradigm"] for row in table_of(kit / "prompts.csv")}
    assert set(prompts) == set(PROMPTS) and set(prompts.values()) == {"camera moves", "board moves", "both move"}
    clips = table_of(kit / "clips.csv")
    assert len(clips) == len({row["clip"] for row in clips}) == len(FORMATS) * len(PROMPTS)
    assert {(row["width"], row["height"], row["fps"]) for row in clips} == {
        ("848", "480", "24"),
        ("1280", "720", "24"),
        ("1920", "1080", "25"),
    }
    assert all((kit / row["frame"]).is_file() and row["prompt"] in prompts for row in clips)


def test_the_list_holds_the_genuine_films_and_takes_clips(kit: Path, films: Path):
    """Catches: a list that evaluate does not read, claims that lead nowhere from the kit."""
    clip = table_of(kit / "clips.csv")[0]
    (kit / "clips" / clip["clip"]).write_bytes((films / "genuine_2.0m.mp4").read_bytes())
    with (kit / "films.csv").open("a", encoding="utf-8") as file:
        file.write(f"clips/{clip['clip']},forged:gen-1,{clip['claim']},{clip['paradigm']},\n")
    found = read_manifest(kit / "films.csv").entries
    assert [(one.label, one.group) for one in found] == [("genuine", "desk"), ("forged:gen-1", "camera moves")]
    assert Path(found[0].video).samefile(films / "genuine_1.0m.mp4")
    assert {one.claimed.badge.name for one in found} == {"published prototype"}


def test_a_picture_is_cut_to_shape_and_never_stretched():
    """Catches: a round thing made oval, the corner taken for the middle, an upright film turned by a right angle."""
    for high, wide in ((1080, 1920), (1920, 1080), (480, 640)):
        y, x = np.mgrid[:high, :wide]
        disc = (np.hypot(x - (wide - 1) / 2, y - (high - 1) / 2) < 100).astype(np.uint8) * 255
        seen = fitted(np.dstack([disc] * 3), 848, 480)
        rows, columns = np.nonzero(seen[..., 0] > 127)
        assert seen.shape == (480, 848, 3) and np.ptp(rows) == pytest.approx(np.ptp(columns), abs=1)
        assert rows.mean() == pytest.approx(239.5, abs=1) and columns.mean() == pytest.approx(423.5, abs=1)
