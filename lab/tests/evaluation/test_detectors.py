"""Scores of other detectors next to ours.  Each test states what it would catch."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid_lab.archive.isolated import LostJob
from moireid_lab.evaluation.collect import ScoredFilm
from moireid_lab.evaluation.detectors import read_detectors, with_detectors
from moireid_lab.evaluation.film_rows import failed_row
from moireid_lab.evaluation.summary import summarise
from moireid_lab.evaluation.table import table


def collection(*films: tuple[str, str, float | None]) -> list[ScoredFilm]:
    """Films of (name, label, our score)."""
    made = []
    for line, (name, label, score) in enumerate(films, start=2):
        genuine = label == "genuine"
        entry: Any = SimpleNamespace(line=line, name=name, label=label, claim="", group=label, genuine=genuine)
        row = failed_row(LostJob("", 1.0, "film")) | {"score": score, "verdict": "accept", "error": None}
        made.append(ScoredFilm(entry, "moireid", row))
    return made


FILMS = collection(
    ("a.mp4", "genuine", 2.0), ("b.mp4", "genuine", 1.0), ("c.mp4", "forged", 1.5), ("d.mp4", "forged", -3.0)
)


def listed(folder: Path, *lines: str) -> Path:
    path = folder / "scores.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_detector_is_compared_with_ours_on_the_same_films(tmp_path: Path) -> None:
    """Catches: a detector of fakes taken for one of genuineness; ours on all films next to its few; a score that turns
    up in the verdicts.
    """
    lines = ("video,detector,fake_score", "a.mp4,lips,0.1", "c.mp4,lips,0.9", "b.mp4,eyes,0.5", "c.mp4,eyes,0.2")
    scores = read_detectors(listed(tmp_path, *lines), [one.entry for one in FILMS])
    assert scores == {"lips": {2: -0.1, 4: -0.9}, "eyes": {3: -0.5, 4: -0.2}}
    plain = summarise(FILMS, seed=0)
    document = json.loads(json.dumps(with_detectors(plain, FILMS, scores, seed=0), allow_nan=False))
    lips, eyes = document["detectors"]["lips"], document["detectors"]["eyes"]
    assert (lips["films"], lips["without_score"]) == (4, 2)
    assert lips["scored_films"]["auc"] == 1.0 and eyes["scored_films"]["auc"] == 0.0
    assert lips["ours_on_these"]["moireid"]["auc"] == 1.0 and eyes["ours_on_these"]["moireid"]["auc"] == 0.0
    assert document["pipelines"] == json.loads(json.dumps(plain["pipelines"]))
    by = {row["video"]: row["detectors"] for row in document["rows"]}
    assert by == {"a.mp4": {"lips": -0.1}, "b.mp4": {"eyes": -0.5}, "c.mp4": {"lips": -0.9, "eyes": -0.2}, "d.mp4": {}}
    assert [row | {"detectors": None} for row in document["rows"]] == [
        row | {"detectors": None} for row in json.loads(json.dumps(plain["rows"]))
    ]
    assert "lips, 2 of 4 films" in table(document) and "no part of a verdict" in table(document)


def test_a_detector_without_a_name_and_with_a_score_that_rises(tmp_path: Path) -> None:
    """Catches: the sign turned round for every list; a detector of forged films alone that breaks the figures."""
    scores = read_detectors(listed(tmp_path, "VIDEO, score", "c.mp4, 0.25", "", "d.mp4,-1e3"), [o.entry for o in FILMS])
    assert scores == {"detector": {4: 0.25, 5: -1000.0}}
    found = with_detectors(summarise(FILMS, seed=0), FILMS, scores, seed=0)["detectors"]["detector"]
    assert "missing" in found["scored_films"] and "auc" not in found["scored_films"]
    assert "no part of a verdict" in table(with_detectors(summarise(FILMS, seed=0), FILMS, scores, seed=0))


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["video,score"], "hold no score"),
        (["film,score", "a.mp4,1"], "has no column video, its first line is 'film,score'"),
        (["video,score,fake_score", "a.mp4,1,0"], "have the columns"),
        (["video,score", "e.mp4,1"], "line 2 of"),
        (["video,score", "a.mp4,1", "a.mp4,2"], "a second score"),
        (["video,score", "a.mp4,nan"], "no finite number"),
        (["video,score", "a.mp4,"], "no finite number"),
        (["video,score", 'a.mp4,"1'], "unexpected end of data"),
    ],
)
def test_a_list_that_cannot_be_used_is_refused(tmp_path: Path, lines: list[str], words: str) -> None:
    """Catches: a film without a score taken for one of 0; a list of other films that counts for nothing in silence."""
    with pytest.raises(SpecError, match=words):
        read_detectors(listed(tmp_path, *lines), [one.entry for one in FILMS])


def test_the_command_reads_the_list_before_any_film(tmp_path: Path, films: Path) -> None:
    """Catches: a list that is found wrong after hours of work."""
    manifest = tmp_path / "films.csv"
    manifest.write_text(f"video,label,claim,group\n{films / 'genuine_1.0m.mp4'},genuine,,\n", encoding="utf-8")
    wrong = listed(tmp_path, "video,score", "other.mp4,1")
    command = ["evaluate", str(manifest), "--badge", str(films / "badge.json"), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(moireid, [*command, "--detector-scores", str(wrong)])
    assert done.exit_code == 2 and "other.mp4" in done.stderr and not (tmp_path / "out").exists()
