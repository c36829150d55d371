"""Kill programs while they write to a registry: run `.venv/bin/python benchmarks/registry_kills.py`, --full for 1,000.

A process enrolls, revokes, signs checkpoints and publishes bundles, by chance and without a pause, until it is killed
at a random moment.  After each kill: the registry must be sound and hold every checkpoint that was written; checkpoint
and bundle must be whole, the old ones or the new ones; and the registry must be in the state that was seen last, or a
later one.  A new registry is begun after every 50 kills, so that audits stay short.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.files import write_text
from moireid.idcodes import specimen_of
from moireid.registry import batch, open_registry
from moireid.registry.bundle.held import Bundle
from moireid.registry.checkpoints.witness import checkpoints_from

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


def main() -> None:
    """Kill, look, and count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="1,000 kills instead of 100")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    kills, chance = 1000 if given.full else 100, random.Random(given.seed)
    first = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    context = multiprocessing.get_context("fork")
    faults, entries, checkpoints, bundles, done = [], 0, 0, 0, 0
    while done < kills:
        with tempfile.TemporaryDirectory() as folder:
            os.environ |= {"MOIREID_KEYS": f"{folder}/keys", "MOIREID_SEEN": f"{folder}/seen.sqlite3"}
            with open_registry(f"sqlite:///{folder}/people.sqlite3", create=True) as registry:
                # Here, so that all that is loaded on first use is loaded before a process is forked.
                registry.enroll(first)
                registry.publish(Path(folder) / "bundle", specimen_of, days=1)
            (Path(folder) / "bundle").unlink()
            for _ in range(min(KILLS_EACH, kills - done)):
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
                done += 1
            with open_registry(f"sqlite:///{folder}/people.sqlite3", create=False) as registry:
                entries += registry.audit().entries
            checkpoints += (Path(folder) / "checkpoint").exists()
            bundles += (Path(folder) / "bundle").exists()
    print(
        f"{kills} kills, {entries} log entries written; registries with a checkpoint {checkpoints}, a bundle {bundles}"
    )
    print(f"unsound: {len(faults)}")
    for fault in faults[:10]:
        print(f"  {fault}")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
