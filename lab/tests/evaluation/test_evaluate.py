"""`moireid evaluate`: the arithmetic, the manifest, going on after a break, and a run over true and forged films."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.stats import mannwhitneyu, norm

from kit.coded_films import first_frames
from moireid.badge import Badge
from moireid.cli.main import moireid
from moireid.errors import SpecError
from moireid.registry import open_registry
from moireid.verifier.video import decoder_version
from moireid_lab.archive.isolated import LostJob
from moireid_lab.evaluation import statistics
from moireid_lab.evaluation.collect import ScoredFilm
from moireid_lab.evaluation.film_rows import FIGURES, Row, failed_row
from moireid_lab.evaluation.manifest import COLUMNS, read_manifest
from moireid_lab.evaluation.plots import PLOTS, write_plots
from moireid_lab.evaluation.summary import summarise
from moireid_lab.evaluation.table import table


def scores(*values: float) -> np.ndarray:
    return np.array(values, float)


def test_a_small_roc_is_the_one_drawn_by_hand():
    """Catches: equal scores that take two steps, axes swapped, an EER taken at a step and not between two."""
    curve = statistics.roc(scores(3, 2, 2), scores(2, 1))
    assert curve.threshold.tolist() == [math.inf, 3, 2, 1]
    assert curve.false_accept.tolist() == [0, 0, 0.5, 1]
    assert curve.true_accept == pytest.approx([0, 1 / 3, 1, 1])
    assert statistics.area(curve) == pytest.approx(5 / 6)
    assert statistics.equal_error(curve) == pytest.approx(2 / 7)


def test_the_area_is_mann_whitney_s_and_that_of_known_normals(rng):
    """Two routes; catches ties that count whole or nothing, films without a score that fall out."""
    genuine = np.concatenate([rng.integers(2, 8, 60).astype(float), [-np.inf] * 5])
    forged = np.concatenate([rng.integers(0, 6, 40).astype(float), [-np.inf] * 9])
    pairs = mannwhitneyu(genuine, forged).statistic / (len(genuine) * len(forged))
    assert statistics.area(statistics.roc(genuine, forged)) == pytest.approx(pairs, abs=1e-12)
    curve = statistics.roc(rng.normal(1, 1, 20000), rng.normal(0, 1, 20000))
    assert statistics.area(curve) == pytest.approx(norm.cdf(1 / math.sqrt(2)), abs=0.01)
    assert statistics.equal_error(curve) == pytest.approx(norm.cdf(-0.5), abs=0.01)


def test_an_interval_of_the_area_keeps_what_it_promises(rng):
    """Catches: an interval that collapses at 1, that ignores the number of films, that covers too seldom."""
    assert statistics.area_interval(1.0, 3, 3)[0] < 0.6 and statistics.area_interval(1.0, 3, 3)[1] == 1.0
    assert statistics.area_interval(0.0, 9, 4) == pytest.approx(
        [1 - x for x in statistics.area_interval(1.0, 9, 4)][::-1]
    )
    narrow, wide = statistics.area_interval(0.845, 200, 200), statistics.area_interval(0.845, 20, 20)
    assert wide[0] < narrow[0] < 0.845 < narrow[1] < wide[1]
    shift, inside = math.sqrt(2) * norm.ppf(0.845), 0
    for _ in range(400):
        curve = statistics.roc(rng.normal(shift, 1, 30), rng.normal(0, 1, 20))
        low, high = statistics.area_interval(statistics.area(curve), 30, 20)
        inside += low <= 0.845 <= high
    assert 0.92 <= inside / 400 <= 0.99


def test_intervals_of_rates_and_resampled_figures(rng):
    """Catches: a rate of nothing with an interval of nothing, resampling without the seed, too few films resampled."""
    assert statistics.interval(0, 0) == (0, 1)
    genuine, forged = rng.normal(1, 1, 60), rng.normal(0, 1, 60)
    low, high = statistics.equal_error_interval(genuine, forged, 1)
    assert low < statistics.equal_error(statistics.roc(genuine, forged)) < high and high - low < 0.3
    assert statistics.equal_error_interval(genuine, forged, 1) == (low, high)
    assert statistics.equal_error_interval(genuine[:4], forged, 1) is None
    assert statistics.equal_error_interval(scores(2, 3, 4), scores(0, 1), 1) == statistics.interval(0, 2)


def test_exact_bounds_are_those_of_the_tables():
    """Catches: a normal approximation, a bound of both sides given for one, a rate of nothing taken for 0."""
    # Clopper and Pearson 1934, as any textbook's table has them: of 0 in n the bound solves (1 - p)^n = 1 - level.
    assert statistics.interval(0, 10) == pytest.approx((0, 1 - 0.025 ** (1 / 10)))
    assert statistics.interval(3, 10) == pytest.approx((0.0667, 0.6525), abs=5e-5)
    assert statistics.interval(10, 10) == pytest.approx((0.025 ** (1 / 10), 1))
    assert statistics.upper_bound(0, 100) == pytest.approx(1 - 0.05 ** (1 / 100)) and statistics.upper_bound(0, 0) == 1
    assert statistics.upper_bound(0, 298) > 0.01 > statistics.upper_bound(0, 299)
    assert statistics.upper_bound(3, 10) == pytest.approx(0.6066, abs=5e-5)


def test_the_cost_of_ratios_is_that_of_known_gaussians(rng):
    """Catches: ratios taken to another base, sides swapped, a calibration that is reported as none, ties set apart.

    Where the natural logarithm of the ratio is normal with mean ±m and variance 2 m, it is its own likelihood ratio.
    """
    assert statistics.cllr(scores(0, 0), scores(0)) == pytest.approx(1.0)
    assert statistics.cllr(scores(1), scores(-2)) == pytest.approx((math.log2(1.1) + math.log2(1.01)) / 2)
    assert statistics.cllr(scores(-1), scores(-1)) == pytest.approx((math.log2(11) + math.log2(1.1)) / 2)
    mean = 3.0
    at = np.linspace(-40, 40, 200001)
    cost = np.sum(norm.pdf(at, mean, math.sqrt(2 * mean)) * np.log2(1 + np.exp(-at))) * (at[1] - at[0])
    true, false = (rng.normal(way * mean, math.sqrt(2 * mean), 100_000) / math.log(10) for way in (1, -1))
    assert statistics.cllr(true, false) == pytest.approx(cost, abs=0.005)
    # What is calibrated loses nothing, and any other scale loses without a change of order.
    assert 0 <= statistics.cllr(true, false) - statistics.least_cllr(true, false) < 0.003
    assert statistics.cllr(3 * true, 3 * false) > cost + 0.05
    assert statistics.least_cllr(3 * true, 3 * false) == pytest.approx(statistics.least_cllr(true, false))


def written(folder: Path, *rows: str, header: str = "video,label,claim,group") -> Path:
    """A manifest next to some files in place of films."""
    for name in ("a.mp4", "b.mp4"):
        (folder / name).write_bytes(name.encode())
    path = folder / "films.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([], "names no film"),
        (["a.mp4,genuine,,", "none.mp4,genuine,,"], "line 3 of films.csv ('none.mp4'): there is no film"),
        (["a.mp4,real,,"], "line 2 of films.csv ('a.mp4'): label 'real' is not known; give genuine, forged"),
        (["a.mp4,forged:,,"], "label 'forged:' is not known"),
        ([",genuine,,"], "there is no film"),
        (["a.mp4,genuine,none.json,"], "line 2 of films.csv ('a.mp4'): badge file"),
        (["a.mp4,genuine,Nobody,", "b.mp4,false,,"], "(1 more lines cannot be used either)"),
        (["a.mp4,genuine,,x,y,z"], "has 6 cells"),
        (['a.mp4,gen"uine",,,"'], "unexpected end of data"),
    ],
)
def test_a_manifest_that_cannot_be_used_is_refused(tmp_path: Path, prototype: Badge, rows: list[str], words: str):
    """Catches: a fault found after an hour's work, or one that names no line."""
    with pytest.raises(SpecError) as refused:
        read_manifest(written(tmp_path, *rows), registry_url=f"sqlite:///{tmp_path}/none.sqlite3", badge=prototype)
    assert words in str(refused.value)


def test_claims_are_files_names_or_ids(tmp_path: Path, prototype: Badge, ada: Badge):
    """Catches: a path taken from where the command runs, an empty group, a name that is not looked up."""
    (tmp_path / "ada.json").write_text(ada.to_json(), encoding="utf-8")
    url = f"sqlite:///{tmp_path}/people.sqlite3"
    with open_registry(url, create=True) as registry:
        registry.enroll(ada)
    rows = ("a.mp4,genuine,ada.json,x", "b.mp4,forged:late,Ada Lovelace,", f"b.mp4,forged,{ada.id},", "b.mp4,genuine")
    found = read_manifest(
        written(tmp_path, *rows, header="Video,label,claim,group,note"), registry_url=url, badge=prototype
    )
    assert [entry.claimed.badge for entry in found.entries] == [ada, ada, ada, prototype]
    assert [entry.group for entry in found.entries] == ["x", "forged:late", "forged", "genuine"]
    assert [entry.genuine for entry in found.entries] == [True, False, False, True] and found.unused == ("note",)
    assert found.entries[0].line == 2 and found.entries[0].video == str(tmp_path / "a.mp4")


def test_the_manifest_of_the_films_made_outside_lists_them_all(films: Path):
    """Catches: a film added without its label, a claim of the other board."""
    found = read_manifest(films / "collection.csv").entries
    assert {Path(entry.video) for entry in found} == set(films.glob("*.mp4"))
    assert all(entry.genuine != entry.name.startswith("forged") for entry in found)
    assert {entry.claimed.badge.lens.kind for entry in found if "rendered" in entry.name} == {"mask"}


def row_of(score: float | None, verdict: str = "accept") -> Row:
    return failed_row(LostJob("", 1.0, "film")) | {"score": score, "verdict": verdict, "error": None}


def collection(*films: tuple[str, str, float | None]) -> list[ScoredFilm]:
    """Scored films of (group, label, score), both pipelines alike."""
    made = []
    for line, (group, label, score) in enumerate(films, start=2):
        entry: Any = SimpleNamespace(
            line=line, name=f"{line}.mp4", label=label, claim="", group=group, genuine=label == "genuine"
        )
        row = row_of(score, "accept" if score and score > 0.6 else "reject")
        made += [ScoredFilm(entry, "moireid", row), ScoredFilm(entry, "published", row)]
    return made


def test_films_without_a_score_are_counted_apart_and_as_least_genuine(tmp_path: Path):
    """Catches: a missing or NaN score taken for 0, dropped in silence, or spread over every mean as NaN."""
    films = (
        ("near", "genuine", 0.9),
        ("near", "genuine", 0.8),
        ("far", "genuine", None),
        ("near", "forged:late", 0.3),
        ("near", "forged:late", -9.0),
        ("sora", "forged", math.nan),
    )
    document = json.loads(json.dumps(summarise(collection(*films), seed=0), allow_nan=False))
    ours = document["pipelines"]["moireid"]
    assert (document["films"], document["genuine"], ours["without_score"], ours["failed"]) == (6, 3, 2, 0)
    assert ours["scored_films"]["auc"] == 1.0 and ours["scored_films"]["genuine"] == 2
    # Of nine pairs the genuine film without a score wins half of one.
    assert ours["all_films"]["auc"] == pytest.approx(6.5 / 9) and ours["all_films"]["roc"]["threshold"][-1] is None
    assert ours["scored_films"]["best_threshold"]["threshold"] == pytest.approx(0.55)
    by = {(row["group"], row["label"]): row for row in ours["groups"]}
    assert by["near", "genuine"]["mean"] == pytest.approx(0.85) and by["near", "forged:late"]["least"] == -9.0
    assert by["far", "genuine"]["mean"] is None and by["sora", "forged"]["scored"] == 0
    assert ours["verdicts"]["genuine"]["accept"]["films"] == 2 and ours["verdicts"]["forged"]["reject"]["films"] == 3
    text = table(document)
    summary = "genuine: 2 of 3 accepted, 1 rejected, 0 without an answer; forged: 3 of 3 rejected"
    assert summary in text.splitlines()[1] and text.splitlines()[1].endswith("AUC 1.000")
    assert "0.845" in text and "0.870 ± 0.140" in text and "paper, other films" in text and "nan" not in text
    for path in write_plots(document, tmp_path):
        assert path.read_text(encoding="utf-8").rstrip().endswith("</svg>")


@pytest.mark.slow
def test_a_collection_is_scored_by_both_pipelines(films: Path, tmp_path: Path):
    """Catches: labels swapped on the way, a broken film that ends the run, a second run that scores again."""
    first_frames(films / "genuine_1.0m.mp4", tmp_path / "true.mp4", 70)
    first_frames(films / "forged_reversed_1.0m.mp4", tmp_path / "reversed.mp4", 70)
    (tmp_path / "broken.mp4").write_bytes(b"no film at all")
    rows = ("true.mp4,genuine,,lab", "reversed.mp4,forged:reversed,,lab", "broken.mp4,genuine,,lab")
    manifest, out = tmp_path / "m.csv", tmp_path / "out"
    manifest.write_text("\n".join([",".join(COLUMNS), *rows]), encoding="utf-8")
    command = ["evaluate", str(manifest), "--badge", str(films / "badge.json"), "--out", str(out)]
    ran = CliRunner().invoke(moireid, [*command, "--workers", "1", "--timeout", "300", "--json"])
    assert ran.exit_code == 0, ran.output
    document = json.loads(ran.stdout)
    assert document == json.loads((out / "evaluate.json").read_text(encoding="utf-8"))
    assert document["manifest"] == "m.csv"
    by = {(row["video"], row["pipeline"]): row for row in document["rows"]}
    assert by["true.mp4", "moireid"]["verdict"] == "accept" and by["reversed.mp4", "moireid"]["verdict"] == "reject"
    assert by["true.mp4", "moireid"]["score"] > 0.99 > by["reversed.mp4", "moireid"]["score"]
    # The baseline is blind to the sign.
    assert by["reversed.mp4", "published"]["verdict"] == "accept" and by["true.mp4", "published"]["gain_ratio"] is None
    true = by["true.mp4", "moireid"]
    assert 0.9 < true["cover"] <= 1 and by["true.mp4", "published"]["cover"] is None
    for pipeline in ("moireid", "published"):
        assert by["broken.mp4", pipeline]["verdict"] == "failed" and "broken.mp4" in by["broken.mp4", pipeline]["error"]
        assert set(FIGURES) <= set(by["true.mp4", pipeline]) and by["true.mp4", pipeline]["frames"] == 70
        assert by["true.mp4", pipeline]["decoder"] == decoder_version()
    assert document["pipelines"]["moireid"]["scored_films"]["auc"] == 1.0
    assert {path.name for path in out.iterdir()} == {
        "evaluate.json",
        "results.jsonl",
        *(f"{name}.svg" for name in PLOTS),
    }

    part = out / "results.jsonl"
    kept = part.read_bytes()
    refused = CliRunner().invoke(moireid, command)
    assert refused.exit_code == 2 and "--overwrite" in refused.stderr
    again = CliRunner().invoke(moireid, [*command, "--overwrite"])
    assert again.exit_code == 0 and "3 films: 2 genuine, 1 forged" in again.stdout and "failed:" in again.stdout
    assert part.read_bytes() == kept
    assert "0 films in" not in again.stderr
