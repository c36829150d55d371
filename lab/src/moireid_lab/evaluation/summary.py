"""From rows to the figures of evaluate.json.

Convention: films without a score (they failed, or nothing could be measured) are counted separately; in figures over
    all films they rank lowest, since no threshold accepts them.  Means and standard deviations are over films
    with a score.

Convention: terms of ISO/IEC 30107-3.  An attack is a forged film, and its kind is in the label; APCER is the share of
    the films of a kind that were accepted, BPCER that of the genuine ones rejected.  Inconclusive or failed films have
    no answer: APNRR and BPNRR are their shares.  All films are in each denominator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.decision.figures import calibrated_log10
from moireid.verifier.limits import MAX_RIVAL_LOG10
from moireid_lab.baseline.pipeline import THRESHOLD
from moireid_lab.evaluation import statistics
from moireid_lab.evaluation.collect import ScoredFilm
from moireid_lab.evaluation.statistics import interval

Array = NDArray[np.float64]
Document = dict[str, Any]
VERDICTS = ("accept", "reject", "inconclusive", "failed")
UNANSWERED = ("inconclusive", "failed")
#: Pipelines whose score, calibrated, is the decadic logarithm of odds.
RATIOS = ("moireid",)
#: Score below which each accepts no film.
LIMITS = {"moireid": -MAX_RIVAL_LOG10, "published": THRESHOLD}
SCORES = {
    "moireid": f"decadic logarithm of the odds of the law over its rivals: below {-MAX_RIVAL_LOG10:g} none is accepted",
    "published": f"greatest |rho| of a window of 30 frames: {THRESHOLD:g} and more is accepted",
}
#: For orientation only: Qing et al., Moiré Video Authentication, 2026, on their own films.
PAPER: dict[str, Any] = {
    "source": "Qing et al. 2026, on a collection of its own",
    "genuine": {"mean": 0.87, "sd": 0.14},
    "forged": {"mean": 0.57, "sd": 0.21},
    "renderings": {"mean": 0.99},
    "auc": 0.845,
    "threshold": THRESHOLD,
}


def summarise(scored: Sequence[ScoredFilm], *, seed: int) -> Document:
    """All figures of a collection.  Parameters: seed: of the resampling.  Returns: an object for JSON."""
    films = {one.entry.line: one.entry for one in scored}
    pipelines = list(dict.fromkeys(one.pipeline for one in scored))
    document: Document = plain(
        {
            "films": len(films),
            "genuine": sum(entry.genuine for entry in films.values()),
            "forged": sum(not entry.genuine for entry in films.values()),
            "seed": seed,
            "pipelines": {
                pipeline: {"score": SCORES[pipeline]} | _figures([o for o in scored if o.pipeline == pipeline], seed)
                for pipeline in pipelines
            },
            "paper": PAPER,
            "rows": [_row(one) for one in scored],
        }
    )
    return document


def scores_of(scored: Sequence[ScoredFilm]) -> Array:
    """Scores (N,) of films; -inf for one without a score."""
    found = [one.row.get("score") for one in scored]
    return np.array([s if isinstance(s, (int, float)) and math.isfinite(s) else -math.inf for s in found], float)


def _figures(scored: list[ScoredFilm], seed: int) -> Document:
    """The figures of one pipeline."""
    genuine = [one for one in scored if one.entry.genuine]
    forged = [one for one in scored if not one.entry.genuine]
    a, b = scores_of(genuine), scores_of(forged)
    kinds = list(dict.fromkeys((one.entry.group, one.entry.label) for one in scored))
    return {
        "failed": sum(one.row["verdict"] == "failed" for one in scored),
        "without_score": int(np.isneginf(np.concatenate([a, b])).sum()),
        "seconds": sum(one.row["seconds"] for one in scored),
        "scored_films": separation(a[np.isfinite(a)], b[np.isfinite(b)], seed, means=True),
        "at_limit": _at_limit(a, b, LIMITS[scored[0].pipeline]),
        "likelihood_ratio": _ratios(a[np.isfinite(a)], b[np.isfinite(b)], scored[0].pipeline, seed),
        "iso_30107_3": _attacks(genuine, forged),
        "all_films": separation(a, b, seed, means=False),
        "window_correlation": {"genuine": _window(genuine), "forged": _window(forged)},
        "verdicts": {"genuine": _verdicts(genuine), "forged": _verdicts(forged)},
        "groups": [
            {"group": group, "label": label} | _group([o for o in scored if _kind(o) == (group, label)])
            for group, label in kinds
        ],
    }


def _kind(one: ScoredFilm) -> tuple[str, str]:
    return one.entry.group, one.entry.label


def separation(genuine: Array, forged: Array, seed: int, *, means: bool) -> Document:
    """How well scores separate genuine films from forged ones; if one kind is missing, `missing` names it.

    Parameters: genuine, forged: arrays (N,), high for genuine; seed: of the resampling; means: also the figures of
        means and spreads, which need finite scores.
    """
    counts = {"genuine": len(genuine), "forged": len(forged)}
    if not len(genuine) or not len(forged):
        lacking = " and no ".join(kind for kind, count in counts.items() if not count)
        return counts | {"missing": f"no {lacking} film has a score, so there is no ROC, AUC, EER or threshold"}
    curve = statistics.roc(genuine, forged)
    auc = statistics.area(curve)
    accuracy, balanced = statistics.accuracies(curve, len(genuine), len(forged))
    found: Document = counts | {
        "auc": auc,
        "auc_interval": statistics.area_interval(auc, len(genuine), len(forged)),
        "eer": statistics.equal_error(curve),
        "eer_interval": statistics.equal_error_interval(genuine, forged, seed),
        "roc": {
            "false_accept": curve.false_accept.tolist(),
            "true_accept": curve.true_accept.tolist(),
            "threshold": curve.threshold.tolist(),
            "accuracy": accuracy.tolist(),
            "balanced_accuracy": balanced.tolist(),
        },
    }
    if means:
        best = statistics.best_threshold(genuine, forged)
        right = round(best.accuracy * (len(genuine) + len(forged)))
        found |= {
            "best_threshold": asdict(best) | {"accuracy_interval": interval(right, len(genuine) + len(forged))},
        }
    return found


def _at_limit(genuine: Array, forged: Array, limit: float) -> Document:
    """Accuracy where every film of that score and more is accepted, and no other; -inf: without a score."""
    films, right = len(genuine) + len(forged), int((genuine >= limit).sum() + (forged < limit).sum())
    balanced = ((genuine >= limit).mean() + (forged < limit).mean()) / 2 if len(genuine) and len(forged) else None
    return {
        "threshold": limit,
        "accuracy": right / films,
        "accuracy_interval": interval(right, films),
        "balanced_accuracy": None if balanced is None else float(balanced),
    }


def _ratios(genuine: Array, forged: Array, pipeline: str, seed: int) -> Document | None:
    """What the calibrated odds of scores (M,), (N,) cost as likelihood ratios; of a score that gives no odds, what it
    would cost if it were calibrated.

    None where there is one kind of films only.
    """
    if not len(genuine) or not len(forged):
        return None
    least = statistics.least_cllr(genuine, forged)
    if pipeline not in RATIOS:
        return {"cllr_min": least}
    genuine, forged = (np.array([calibrated_log10(score) for score in some]) for some in (genuine, forged))
    cost = statistics.cllr(genuine, forged)
    return {
        "cllr": cost,
        "cllr_interval": statistics.resampled_interval(statistics.cllr, genuine, forged, seed),
        "cllr_min": least,
        "calibration_loss": cost - least,
        "misleading": {
            "genuine": _rate(int((genuine < 0).sum()), len(genuine)),
            "forged": _rate(int((forged > 0).sum()), len(forged)),
        },
    }


def _attacks(genuine: list[ScoredFilm], forged: list[ScoredFilm]) -> Document:
    """Error rates of presentation attack detection: of each kind of attack, the worst of them, and of genuine films."""
    kinds: dict[str, list[str]] = {}
    for one in forged:
        kinds.setdefault(one.entry.label.partition(":")[2] or "not named", []).append(one.row["verdict"])
    attacks: list[Document] = [
        {"kind": kind, "apcer": _share(given, "accept"), "apnrr": _share(given, *UNANSWERED)}
        for kind, given in kinds.items()
    ]
    # Of kinds with equal rates the one is worst of which the films say least.
    worst = max(attacks, key=lambda one: (one["apcer"]["rate"], one["apcer"]["upper_bound"]), default=None)
    given = [one.row["verdict"] for one in genuine]
    return {
        "attacks": attacks,
        "apcer_max": worst["apcer"] | {"kind": worst["kind"]} if worst else None,
        "bpcer": _share(given, "reject") if given else None,
        "bpnrr": _share(given, *UNANSWERED) if given else None,
    }


def _share(given: list[str], *verdicts: str) -> Document:
    return _rate(sum(verdict in verdicts for verdict in given), len(given))


def _rate(hits: int, of: int) -> Document:
    """A rate with its exact bounds, of both sides and of the upper one alone."""
    bound = statistics.upper_bound(hits, of)
    return {"films": hits, "of": of, "rate": hits / of, "interval": interval(hits, of), "upper_bound": bound}


def _window(scored: list[ScoredFilm]) -> Document:
    """Mean and standard deviation of the published figure, mean |rho| over windows of 30 frames, for both pipelines."""
    found = [one.row.get("window_correlation_mean") for one in scored]
    values = np.array([value for value in found if value is not None], float)
    mean, sd = (float(values.mean()), float(values.std(ddof=1))) if len(values) > 1 else (None, None)
    return {"films": len(values), "mean": mean, "sd": sd}


def _verdicts(scored: list[ScoredFilm]) -> Document:
    """Number of films with each verdict, with the interval of the rate."""
    given = [one.row["verdict"] for one in scored]
    return {
        verdict: {
            "films": given.count(verdict),
            "of": len(given),
            "interval": interval(given.count(verdict), len(given)),
        }
        for verdict in VERDICTS
    }


def _group(scored: list[ScoredFilm]) -> Document:
    """Distribution of the scores of films of one group and label, and their verdicts."""
    scores = scores_of(scored)
    scores = scores[np.isfinite(scores)]
    names = ("least", "lower_quartile", "median", "upper_quartile", "most")
    five = np.quantile(scores, [0, 0.25, 0.5, 0.75, 1]).tolist() if len(scores) else [None] * 5
    return {
        "films": len(scored),
        "scored": len(scores),
        "mean": float(scores.mean()) if len(scores) else None,
        "sd": float(scores.std(ddof=1)) if len(scores) > 1 else None,
        **dict(zip(names, five, strict=True)),
        "verdicts": _verdicts(scored),
    }


def _row(one: ScoredFilm) -> Document:
    entry = one.entry
    return {
        "line": entry.line,
        "video": entry.name,
        "label": entry.label,
        "claim": entry.claim,
        "group": entry.group,
        "pipeline": one.pipeline,
        **{name: value for name, value in one.row.items() if name not in ("key", "film", "claim", "program")},
    }


def plain(value: Any) -> Any:
    """The value for JSON, null if it is not finite.  It is not rounded: a rounded threshold could misclassify films."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
