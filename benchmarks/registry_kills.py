"""Kill programs while they write to a registry: run `.venv/bin/python benchmarks/registry_kills.py`, --clips 1000
for more.

A process enrolls, revokes, signs checkpoints and publishes bundles, by chance and without a pause, until it is killed
at a random moment.  After each kill: the registry must be sound and hold every checkpoint that was written; checkpoint
and bundle must be whole, the old ones or the new ones; and the registry must be in the state that was seen last, or a
later one.  A new registry is begun after every 50 kills, so that audits stay short.
"""

from __future__ import annotations

import multiprocessing
import os
import random
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.files import write_text
from moireid.idcodes import specimen_of
from moireid.registry import batch, open_registry
from moireid.registry.bundle.held import Bundle
from moireid.registry.checkpoints.sources import checkpoints_from
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

#: Kills until a new registry is begun, and the longest life of a process, s.
KILLS_EACH, LIFE_S = 50, 0.3


def work(folder: str, first: Badge, seed: int, begun: object) -> None:
    """Write without a pause, until this process is killed."""
    chance = random.Random(seed)
    batch.CHUNK = 3
    with open_registry(f"sqlite:///{folder}/people.sqlite3", create=False) as registry:
        begun.set()  # type: ignore[attr-defined]
        while True:
            act = chance.choice(("enroll", "revoke", "checkpoint", "publish"))
            if act == "enroll":
                ids = [f"{chance.getrandbits(64):016x}" for _ in range(6)]
                registry.enroll_many(replace(first, id=one, name=f"Person {one}") for one in ids)
            elif act == "revoke":
                valid = [record.id for record in registry.records() if record.revoked_at is None]
                if valid:
                    registry.revoke(chance.choice(valid), "lost")
            elif act == "checkpoint":
                write_text(Path(folder) / "checkpoint", registry.checkpoint()[0].note)
            else:
                registry.publish(Path(folder) / "bundle", specimen_of, days=1, overwrite=True)


def unsound(folder: str) -> list[str]:
    """What does not hold after a kill; empty where everything does."""
    found, checkpoint, bundle = [], Path(folder) / "checkpoint", Path(folder) / "bundle"
    with open_registry(f"sqlite:///{folder}/people.sqlite3", create=False) as registry:
        since = checkpoints_from(str(checkpoint)) if checkpoint.exists() else []
        found += [one.text for one in registry.audit(since=since).findings]
        if bundle.exists():
            # Of its own memory: between two bundles the registry itself may have grown, which is no step back.
            os.environ["MOIREID_SEEN"] = f"{folder}/seen-bundles.sqlite3"
            Bundle(bundle)
            os.environ["MOIREID_SEEN"] = f"{folder}/seen.sqlite3"
        registry.standing()
    return found


def rows(wish: Wish) -> Iterator[Row]:
    """One row a registry."""
    kills, chance = wish.clips or (10 if wish.quick else 100), random.Random(wish.seed or 1)
    for begun in range(0, kills, KILLS_EACH):
        with tempfile.TemporaryDirectory() as folder:
            yield {"registry": begun // KILLS_EACH + 1} | killed(folder, min(KILLS_EACH, kills - begun), chance)


def killed(folder: str, kills: int, chance: random.Random) -> Row:
    """Kill so many programs as they write to one registry, and look after each."""
    first = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    context, faults = multiprocessing.get_context("fork"), list[str]()
    os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
    with open_registry(f"sqlite:///{folder}/people.sqlite3", create=True) as registry:
        # Here, so that all that is loaded on first use is loaded before a process is forked.
        registry.enroll(first)
        registry.publish(Path(folder) / "bundle", specimen_of, days=1)
    (Path(folder) / "bundle").unlink()
    for _ in range(kills):
        begun = context.Event()
        process = context.Process(target=work, args=(folder, first, chance.getrandbits(32), begun))
        process.start()
        begun.wait(60)
        time.sleep(chance.uniform(0, LIFE_S))
        process.kill()
        process.join()
        try:
            faults += unsound(folder)
        except Exception as error:  # noqa: BLE001 - whatever it is, this kill left something unsound.
            faults.append(f"{type(error).__name__}: {error}")
    with open_registry(f"sqlite:///{folder}/people.sqlite3", create=False) as registry:
        entries = registry.audit().entries
    there = {name: (Path(folder) / name).exists() for name in ("checkpoint", "bundle")}
    return {"kills": kills, "entries": entries, **there, "unsound": len(faults), "faults": faults[:10]}


def check(found: list[Row]) -> Iterator[str]:
    """Exit code 1 where something was unsound."""
    yield f"{sum(row['kills'] for row in found)} kills, unsound: {sum(row['unsound'] for row in found)}"
    if any(row["unsound"] for row in found):
        raise SystemExit(1)


COLUMNS = {"registry": ">8", "kills": ">5", "entries": ">7", "checkpoint": ">10", "bundle": ">6", "unsound": ">7"}
BENCH = Bench(rows, COLUMNS | {"faults": "<1"}, check)

if __name__ == "__main__":
    run_script(__file__)
