"""What a process for each film costs a collection: run `benchmarks/collection_cost.py`.

The same least work is done with a film, in a process of its own that is forked and sealed, and without one, in a
process that does all such jobs, in turns.  The first of each is left out, as it loads the program.
"""

from __future__ import annotations

import pickle
import time
from collections.abc import Iterator
from statistics import median

from start_up import FILMS

from moireid_lab.archive.isolated import IsolatedProcess, Limits
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

#: A work that takes a job, and a job with a film.
PAYLOAD = pickle.dumps((max, "job"))
KINDS = {"a process each, sealed": str(FILMS / "genuine_1.0m.mp4"), "one process": None}


def rows(wish: Wish) -> Iterator[Row]:
    """A row a kind of process."""
    processes = {kind: IsolatedProcess("moireid_lab.evaluation.film_rows", Limits()) for kind in KINDS}
    times: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for _ in range(1 + (wish.clips or (10 if wish.quick else 100))):
        for kind, film in KINDS.items():
            begun = time.perf_counter()
            processes[kind].do(PAYLOAD, film)
            times[kind].append(1e3 * (time.perf_counter() - begun))
    for kind, (_, *later) in times.items():
        processes[kind].end()
        yield {"process": kind, "median ms": median(later), "least ms": min(later), "jobs": len(later)}


BENCH = Bench(rows, {"process": "<24", "median ms": ">9.1f", "least ms": ">8.1f", "jobs": ">4"})

if __name__ == "__main__":
    run_script(__file__)
