"""What the seal costs a verify: run `.venv/bin/python benchmarks/sealed_cost.py [--clips RUNS]`.

Each film is verified by the command in a process of its own, sealed and with `--unsealed`, in turns.  CPU seconds are
those of the command and its sealed process; the least of the runs, as others only show what else the machine did.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from start_up import FILM_S, FILMS, beginning, cost_s

from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

NAMES = ("genuine_1.0m", "genuine_2.0m")


def rows(wish: Wish) -> Iterator[Row]:
    """A row a film, with what the seal adds."""
    with tempfile.TemporaryDirectory() as folder:
        films = {name: FILMS / f"{name}.mp4" for name in NAMES}
        films[f"{FILM_S:g} s of {NAMES[0]}"] = beginning(films[NAMES[0]], Path(folder) / "film.mp4", FILM_S)
        for name in wish.chosen(films):
            command = ["verify", str(films[name]), "--badge", str(FILMS / "badge.json"), "--json"]
            sealed, plain = [], []
            for _ in range(wish.clips or (2 if wish.quick else 9)):
                sealed.append(cost_s(command))
                plain.append(cost_s([*command, "--unsealed"]))
            (cpu, wall), (plain_cpu, plain_wall) = (map(min, zip(*runs, strict=True)) for runs in (sealed, plain))
            added = {"added s": cpu - plain_cpu, "added %": 100 * (cpu / plain_cpu - 1)}
            yield {"film": name, "sealed s": cpu, "unsealed s": plain_cpu} | added | {"wall added s": wall - plain_wall}


COLUMNS = {"film": "<24", "sealed s": ">9.2f", "unsealed s": ">11.2f", "added s": ">8.2f", "added %": ">8.1f"}
BENCH = Bench(rows, COLUMNS | {"wall added s": ">13.2f"})

if __name__ == "__main__":
    run_script(__file__)
