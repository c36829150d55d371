"""The columns of `results/part-*.parquet`; each file has the same texts as its fields' `description`.

A row is one film scored by one pipeline.  Labels and groups are in the manifest, and are joined to rows by `film`.
"""

from __future__ import annotations

COLUMNS: dict[str, tuple[str, str]] = {
    "key": ("string", "names the row: film, claim, pipeline and program that scored; no two rows have one key"),
    "film": ("string", "address of the film"),
    "sha256": ("string", "of the film's content; null where it was not read"),
    "claim": ("string", "first 16 hex digits of the SHA-256 of the claimed badge's JSON"),
    "pipeline": ("string", "moireid, or published: the published baseline"),
    "program": ("string", "digest of the sources that scored"),
    "verdict": ("string", "accept, reject, inconclusive; failed: could not be scored"),
    "motion": ("string", "verdict of the motion alone"),
    "identity": ("string", "match, mismatch, unreadable, not_claimed"),
    "score": (
        "double",
        "moireid: decadic log of the odds of the law over its rivals; published: greatest |rho| of a window",
    ),
    "window_correlation_mean": ("double", "mean of |rho| over windows of 30 frames, in both pipelines"),
    "window_correlation_max": ("double", "the greatest of these windows; null in moireid"),
    "window_correlation_min": ("double", "the least; null in moireid"),
    "window_correlation_sd": ("double", "their standard deviation; null in moireid"),
    "correlation": ("double", "|rho| of measured and predicted phase over the whole film"),
    "gain_ratio": ("double", "measured over predicted phase, 1 for genuine; null in published"),
    "gain_sd": ("double", "its standard error"),
    "phase_residual_rad": ("double", "what is left over, radians"),
    "excitation_rad": ("double", "standard deviation of the predicted phase, radians"),
    "cover": ("double", "share of the film that the verdict is of, 0 to 1; null in published"),
    "photographs": ("double", "so many photographs of the badge would make the film; null in published"),
    "frames": ("int64", "frames read"),
    "tracked": ("int64", "frames in which the badge was followed"),
    "seconds": ("double", "that scoring took, on one processor, fetching apart"),
    "codes": ("list<string>", "of the reasons that keep the film from being accepted"),
    "reason": ("string", "the first of them, in words"),
    "error": ("string", "why the film could not be scored"),
    "fault": ("string", "kind of that: film, crash, time, memory, program, fetch, worker"),
    "again": ("bool", "whether the next run tries once more, as the fault may pass"),
    "worker": ("string", "name of the worker that scored it; here: no cluster"),
}
