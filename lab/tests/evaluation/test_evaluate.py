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
from moireid.result_cache import keep_row, kept_rows, program_digest
from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.video import decoder_version
from moireid_lab.archive.isolated import LostJob
from moireid_lab.evaluation import statistics
from moireid_lab.evaluation.collect import ScoredFilm
from moireid_lab.evaluation.film_rows import FIGURES, Row, failed_row
from moireid_lab.evaluation.manifest import COLUMNS, Entry, read_manifest
from moireid_lab.evaluation.plots import PLOTS, _steps, write_plots
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


@pytest.mark.parametrize(
    ("genuine", "forged", "threshold", "accuracy", "balanced"),
    [
        # Above 4 and above 2 both put four of five right; the second lets no genuine film go.
        (scores(5, 3), scores(4, 2, 1), 2.5, 0.8, 5 / 6),
        # Here the first of two ties is the balanced one.
        (scores(5, 4, 2), scores(3, 1), 3.5, 0.8, 5 / 6),
        (scores(2, 3), scores(0, 1), 1.5, 1.0, 1.0),
        # All forged films score higher: accepting nothing is best, or everything, whichever kind is commoner.
        (scores(0), scores(1, 2), math.nextafter(2, 3), 2 / 3, 0.5),
        (scores(0, 0.5), scores(1), 0.0, 2 / 3, 0.5),
    ],
)
def test_the_threshold_of_greatest_accuracy(genuine, forged, threshold, accuracy, balanced):
    """Catches: a tie left to chance, the middle of the wrong gap, a threshold that does not give its own accuracy."""
    best = statistics.best_threshold(genuine, forged)
    assert best.threshold == pytest.approx(threshold, rel=1e-15)
    assert best.accuracy == pytest.approx(accuracy) and best.balanced_accuracy == pytest.approx(balanced)
    right = (genuine >= best.threshold).sum() + (forged < best.threshold).sum()
    assert right / (len(genuine) + len(forged)) == pytest.approx(accuracy)
    assert best.false_accept == np.mean(forged >= best.threshold)
    assert best.false_reject == pytest.approx(np.mean(genuine < best.threshold))


def test_intervals_of_rates_and_resampled_figures(rng):
    """Catches: a rate of nothing with an interval of nothing, resampling without the seed, too few films resampled."""
    assert statistics.interval(0, 8) == pytest.approx((0, 1 - 0.025 ** (1 / 8)))
    assert statistics.interval(8, 8) == pytest.approx((0.025 ** (1 / 8), 1)) and statistics.interval(0, 0) == (0, 1)
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


def test_calibration_on_a_few_films_is_the_one_done_by_hand():
    """Catches: ties in their given order, a prior that is forgotten, ratios that are endless and make no number."""
    assert statistics.least_cllr(scores(2, 3), scores(0, 1)) == 0.0
    # All films pool, so every ratio is 1 whatever the numbers of films.
    assert statistics.least_cllr(scores(0), scores(1, 2, 3)) == pytest.approx(1.0)
    assert statistics.least_cllr(scores(1, 1), scores(1)) == pytest.approx(1.0)
    # 1 and 2 pool, half genuine, which is a ratio of 1/2 against the prior's 2: half of each side has that.
    pooled = (math.log2(1 + 2) / 2 + math.log2(1 + 0.5)) / 2
    assert statistics.least_cllr(scores(1, 3), scores(2)) == pytest.approx(pooled)


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


def test_columns_that_lack_or_come_twice_are_named(tmp_path: Path, prototype: Badge):
    """Catches: a KeyError, a column that silently holds for another."""
    for header, words in (
        ("video,label", "no column claim and no column group"),
        ("", "no column video"),
        ("video,label,claim,group,Label", "twice"),
    ):
        with pytest.raises(SpecError, match=words):
            read_manifest(written(tmp_path, "a.mp4,genuine", header=header), badge=prototype)
    with pytest.raises(SpecError, match="cannot be read"):
        read_manifest(tmp_path / "absent.csv", badge=prototype)
    with pytest.raises(SpecError, match="add --badge"):
        read_manifest(written(tmp_path, "a.mp4,genuine"))


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


def test_kept_rows_outlive_a_line_that_was_cut_off(tmp_path: Path):
    """Catches: the next row written onto the end of a broken line, an old row that outlives a newer one."""
    path = tmp_path / "kept.jsonl"
    keep_row(path, "a", {"n": 1})
    with path.open("a") as file:
        file.write('{"key": "b", "ro')
    keep_row(path, "c", {"n": 3})
    keep_row(path, "a", {"n": 4})
    with path.open("a") as file:
        file.write('[1]\n{"key": 1, "row": {}}\n')
    assert kept_rows(path) == {"a": {"n": 4}, "c": {"n": 3}} and kept_rows(tmp_path / "absent") == {}
    assert program_digest("verifier") != program_digest("registry") != program_digest()


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
    assert "0.845" in text and "0.870 ± 0.140" in text and "paper, other films" in text and "nan" not in text
    for path in write_plots(document, tmp_path):
        assert path.read_text(encoding="utf-8").rstrip().endswith("</svg>")


def test_attacks_are_reported_by_their_kind_and_the_worst_of_them(tmp_path: Path):
    """Catches: kinds averaged into one rate, inconclusive films taken for caught or accepted, a wrong worst kind."""
    films = (
        *[("g", "genuine", 0.9)] * 3,
        ("g", "genuine", 0.1),
        *[("g", "forged:late", 0.8)],
        *[("g", "forged:late", -3.0)] * 3,
        *[("g", "forged:photo", 0.7)],
        *[("g", "forged:photo", -1.0)],
        ("g", "forged", -2.0),
    )
    made = collection(*films)
    # The forged film of no kind is inconclusive, and one of the late ones failed.
    made[-2].row["verdict"], made[8].row["verdict"] = "inconclusive", "accept"
    made[10].row["verdict"] = "failed"
    document = json.loads(json.dumps(summarise(made, seed=0), allow_nan=False))
    found = document["pipelines"]["moireid"]["iso_30107_3"]
    rates = {one["kind"]: (one["apcer"]["rate"], one["apnrr"]["rate"]) for one in found["attacks"]}
    assert rates == {"late": (0.25, 0.25), "photo": (0.5, 0.0), "not named": (0.0, 1.0)}
    assert (found["apcer_max"]["kind"], found["apcer_max"]["films"], found["apcer_max"]["of"]) == ("photo", 1, 2)
    assert found["apcer_max"]["interval"] == pytest.approx(statistics.interval(1, 2))
    assert found["bpcer"]["rate"] == 0.25 and found["bpnrr"]["rate"] == 0.0
    ratio = document["pipelines"]["moireid"]["likelihood_ratio"]
    assert ratio["cllr"] == pytest.approx(ratio["cllr_min"] + ratio["calibration_loss"])
    true = [calibrated_log10(score) for _, label, score in films if label == "genuine"]
    false = [calibrated_log10(score) for _, label, score in films if label != "genuine"]
    assert ratio["cllr"] == pytest.approx(statistics.cllr(scores(*true), scores(*false)))
    assert ratio["misleading"]["forged"]["films"] == sum(odds > 0 for odds in false)
    assert ratio["misleading"]["genuine"]["films"] == sum(odds < 0 for odds in true)
    # The published score is a correlation, and no ratio.
    assert set(document["pipelines"]["published"]["likelihood_ratio"]) == {"cllr_min"}
    # At -1 and more: all genuine ones, and three forged; 0.927 accepts nothing.
    limits = {name: document["pipelines"][name]["at_limit"] for name in ("moireid", "published")}
    assert limits["moireid"]["accuracy"] == pytest.approx(8 / 11)
    assert limits["published"]["balanced_accuracy"] == pytest.approx(0.5)
    text = table(document)
    assert "APCER, greatest of any kind" in text and "BPNRR" in text and "Cllr" in text
    assert {path.name for path in write_plots(document, tmp_path)} >= {"roc.svg", "tippett.svg"}


def test_a_curve_over_thresholds_is_that_of_the_films(tmp_path: Path):
    """Catches: shares of films above a score for those at it and above, a curve that ends at its last film."""
    document = json.loads(
        json.dumps(
            summarise(
                collection(("a", "genuine", 0.5), ("a", "genuine", 1.0), ("a", "genuine", None), ("a", "forged", -1.0)),
                seed=0,
            )
        )
    )
    at, shares = _steps(document["pipelines"]["moireid"]["all_films"], "true_accept", -8.0, 3.0)
    assert at.tolist() == [-8, -1, -1, 0.5, 0.5, 1, 1, 3]
    assert shares == pytest.approx(np.repeat([2 / 3, 2 / 3, 1 / 3, 0], 2))


def test_films_of_one_kind_alone_have_no_roc_but_the_rest(tmp_path: Path):
    """Catches: a division by the number of forged films, an AUC of 0 for none."""
    document = summarise(collection(("a", "genuine", 0.9), ("b", "genuine", 0.7)), seed=0)
    ours = document["pipelines"]["moireid"]
    assert "auc" not in ours["scored_films"] and "no forged film" in ours["all_films"]["missing"]
    assert ours["groups"][0]["mean"] == 0.9
    assert "no forged film has a score, so there is no ROC" in table(document)
    assert len(write_plots(document, tmp_path)) == len(PLOTS)


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


@pytest.mark.parametrize(
    "more", [["--scheduler", "tcp://a.test:1"], ["--scheduler", "tcp://127.0.0.1:1", "--workers", "2"]]
)
def test_a_scheduler_that_cannot_be_used_is_reported(tmp_path: Path, films: Path, more: list[str]):
    """Catches: a traceback of another package, films scored here when they were to be scored there."""
    manifest = written(tmp_path, "a.mp4,genuine,,", "b.mp4,forged,,")
    command = ["evaluate", str(manifest), "--badge", str(films / "badge.json"), "--out", str(tmp_path / "out"), *more]
    ran = CliRunner().invoke(moireid, command)
    assert ran.exit_code == 2 and not ran.stdout and ran.stderr.count("\n") == 1, ran.stderr
    assert ran.stderr.startswith(("error: every program that reaches the scheduler", "error: 2 workers are asked for"))
    assert not (tmp_path / "out" / "results.jsonl").exists()


def test_a_manifest_names_corners(tmp_path: Path, prototype: Badge):
    """Catches: corners passed over, read from elsewhere, or found wrong only when the film is scored."""
    (tmp_path / "corners.csv").write_text("frame,x1,y1,x2,y2,x3,y3,x4,y4\n0,10,10,90,12,92,80,11,85\n")
    header = "video,label,claim,group,corners"
    found: tuple[Entry, ...] = read_manifest(
        written(tmp_path, "a.mp4,genuine,,,corners.csv", "b.mp4,genuine,,,", header=header), badge=prototype
    ).entries
    assert found[0].corners is not None and found[0].corners[0][1] == pytest.approx([90, 12])
    assert found[1].corners is None
    with pytest.raises(SpecError, match="line 2 of films"):
        read_manifest(written(tmp_path, "a.mp4,genuine,,,none.csv", header=header), badge=prototype)
