"""Each format under the sheets that it could have: run `.venv/bin/python benchmarks/default_sheets.py [--films N]`.

A format's default sheet is a product that is sold.  Here every format is designed for each candidate, built as usual,
and filmed at the middle and at the far end of where eight seconds of swaying are enough.  Printed are the verdicts of
true films and of forged ones, whether the identity was read, and the mean score of the true films.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import mean

from moireid.badge import Badge
from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.designer.reach import verdict_reach_m
from moireid.simulate import Build, Scene, camera_named, motion_named
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, grouped, run_script, temporary_film

SHEETS = ("50lpi", "40lpi-33mil", "62lpi-27mil", "75lpi-18mil", "60lpi-1.2mm")
FORGERIES = (None, "drift")
FRAMES, FPS = 240, 30


def distances_m(badge: Badge) -> tuple[float, float]:
    """The middle and the far end of where a film is long enough for a verdict, m."""
    assert badge.range_m is not None
    near, far = badge.range_m[0], min(badge.range_m[1], verdict_reach_m(badge))
    return round((near + far) / 2, 2), round(far, 2)


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    for name in wish.chosen(f"{form} {sheet}" for form in FORMATS for sheet in SHEETS):
        form, sheet = name.split()
        badge = design_badge(in_format(Request("Bench"), form, lens=sheet), bytes.fromhex("0f5ac3962d784be1"))
        for seed in wish.seeds(2):
            for metres in distances_m(badge):
                for forge in FORGERIES:
                    scene = Scene(badge, Build.typical(seed), camera_named("phone"))
                    course = motion_named("sway", distance_mm=1000 * metres, seed=seed)
                    with temporary_film(scene, course, frames=FRAMES, fps=FPS, forge=forge, seed=seed) as video:
                        report = verify(video, Claim(badge, badge.id))
                    yield {
                        "format": form,
                        "sheet": sheet,
                        "m": metres,
                        "film": forge or "true",
                        "seed": seed,
                        "verdict": report.verdict,
                        "identity": report.identity.verdict,
                        "score": report.invariant.score,
                    }


def sums(found: Sequence[Row]) -> Iterator[str]:
    """Of each format and sheet: true films accepted, forged ones accepted, identities read, the mean score."""
    for (form, sheet), films in grouped(found, "format", "sheet").items():
        true = [row for row in films if row["film"] == "true"]
        forged = [row for row in films if row["film"] != "true"]
        taken = sum(row["verdict"] == "accept" for row in true)
        passed = sum(row["verdict"] == "accept" for row in forged)
        read = sum(row["identity"] == "match" for row in true)
        yield (
            f"{form:<8}{sheet:<13} true accepted {taken} of {len(true)}, identity {read} of {len(true)}, "
            f"forged accepted {passed} of {len(forged)}, mean score {mean(row['score'] for row in true):.1f}"
        )


COLUMNS = {"format": "<7", "sheet": "<12", "m": ">5.2f", "film": "<9", "seed": ">4", "verdict": "<12"}
BENCH = Bench(rows, COLUMNS | {"identity": "<10", "score": ">7.1f"}, sums)

if __name__ == "__main__":
    run_script(__file__)
