"""Sets of films from a plan.  Each test states the wrong implementation that it catches."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from kit.in_place import in_place
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid_lab.bench import film_set
from moireid_lab.commands.film_set_cmd import read_plan
from moireid_lab.evaluation.manifest import read_manifest

PLAN = "badge,name,group,motion,distance,frames,forge,flaw,seed\n"
FILMS = "ada.json,true,near,course.csv,1.0,3,,,4\nada.json,,,sway,2.0,4,drift,haze=0.2 air=0.1,5\n"


@pytest.fixture
def plan(tmp_path: Path, ada: Badge) -> Path:
    (tmp_path / "ada.json").write_text(ada.to_json())
    times = np.arange(0, 3, 0.1)
    rows = [f"{t:.1f},{20 * t:.2f},0,-1000,0,0,0,1" for t in times]
    (tmp_path / "course.csv").write_text("t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\n" + "\n".join(rows))
    (tmp_path / "plan.csv").write_text(PLAN + FILMS)
    return tmp_path / "plan.csv"


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Films made in this process: one test below has them made by the engine."""
    monkeypatch.setattr(film_set, "run_tasks", in_place)


def ran(*words: str | Path) -> Result:
    return CliRunner().invoke(moireid, [str(word) for word in words], standalone_mode=False)


@pytest.mark.slow
def test_a_plan_becomes_the_films_that_simulate_makes_and_a_list_that_evaluate_reads(plan: Path, tmp_path: Path):
    """Catches: a column that is read and not handed on, a course that the worker cannot find, a label that is wrong."""
    made = ran("lab", "film-set", plan, "--out", tmp_path / "set", "--workers", "1", "--json")
    assert made.exit_code == 0, made.output
    one = ["--motion", tmp_path / "course.csv", "--distance", "1.0", "--frames", "3", "--seed", "4"]
    other = ["--motion", "sway", "--distance", "2.0", "--frames", "4", "--forge", "drift", "--seed", "5"]
    other += ["--flaw", "haze=0.2", "--flaw", "air=0.1"]
    for name, options in (("true", one), ("0002", other)):
        alone = tmp_path / f"{name}.mp4"
        assert ran("simulate", tmp_path / "ada.json", "--out", alone, *options).exit_code == 0
        for suffix in (".mp4", ".mp4.truth.csv"):
            assert (tmp_path / "set" / f"{name}{suffix}").read_bytes() == (tmp_path / f"{name}{suffix}").read_bytes()
    entries = read_manifest(tmp_path / "set" / "films.csv").entries
    assert [(one.name, one.label, one.group) for one in entries] == [
        ("true.mp4", "genuine", "near"),
        ("0002.mp4", "forged:drift", "forged:drift"),
    ]
    assert all(one.claimed.badge.name == "Ada Lovelace" for one in entries)


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_a_set_goes_on_where_it_stopped_and_replaces_nothing_unasked(plan: Path, tmp_path: Path):
    """Catches: films made again that are there; films kept that the plan now asks for otherwise."""
    folder = tmp_path / "set"
    command = ("lab", "film-set", plan, "--out", folder, "--workers", "1")
    assert ran(*command).exit_code == 0
    before = {path.name: path.stat().st_ino for path in folder.glob("*.mp4")}
    (folder / "0002.mp4").unlink()
    (folder / "0002.mp4.truth.csv").unlink()
    (folder / "films.csv").unlink()
    assert ran(*command).exit_code == 0
    assert (folder / "true.mp4").stat().st_ino == before["true.mp4"] and (folder / "films.csv").exists()
    plan.write_text(PLAN + FILMS.replace("drift", "reversed"))
    refused = ran(*command)
    assert refused.exit_code == 2 and "0002.mp4.truth.csv exists already" in refused.output
    assert ran(*command, "--overwrite").exit_code == 0
    with (folder / "films.csv").open() as file:
        assert [row["label"] for row in csv.DictReader(file)] == ["genuine", "forged:reversed"]
    assert (folder / "true.mp4").stat().st_ino == before["true.mp4"]
    # The plan as it was at first: the film of that name is another one now.
    plan.write_text(PLAN + FILMS)
    assert "0002.mp4.truth.csv exists already" in ran(*command).output
    assert ran(*command, "--overwrite").exit_code == 0 and "forged:drift" in (folder / "films.csv").read_text()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no column badge"),
        ("badge,colour\nada.json,red\n", "a column 'colour'"),
        ("badge,motion\n,sway\n", "line 2"),
        ("badge,seed\nada.json,x\n", "'--seed'"),
        ("badge,name\nada.json,../up\n", "no name for a file"),
        ("badge,motion\nada.json,s\0y\n", "holds a NUL"),
        ("badge,name\nada.json,A\nada.json,a\n", "2 films 'a'"),
        ("badge,motion\nada.json,gone.csv\n", "gone.csv cannot be read"),
        ("badge\nmissing.json\n", "missing.json"),
    ],
)
def test_a_plan_that_cannot_be_used_names_its_line(plan: Path, text: str, words: str):
    """Catches: a traceback, or films made of half a plan."""
    plan.write_text(text)
    with pytest.raises(SpecError, match=".*" + words.replace("(", r"\(")):
        read_plan(plan)
