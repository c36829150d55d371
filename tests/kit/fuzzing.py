"""A reader of untrusted files fuzzed by coverage: `python -m kit.fuzzing READER SECONDS FOLDER [--keep]`.

A reader of `kit.untrusted_readers` takes a content or refuses it; any other error is a fault, and so is a content that
takes longer than `MOST_S` or more than `MOST_MB`.  Its kept corpus is where the search begins; what reaches more code
is added to FOLDER, and a fault is written next to it.  The exit code is 0 where none was found.
--keep: the least contents of FOLDER that reach as much replace the kept corpus.
Source: Atheris, whose engine is libFuzzer.
"""

from __future__ import annotations

import json
import random
import resource
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import atheris

with atheris.instrument_imports(include=["moireid"], enable_loader_override=False):
    from kit.untrusted_readers import CORPORA, READERS, kept_corpus

MOST_S, MOST_MB, MOST_BYTES = 10, 1024, 1 << 18
#: So many sound contents are kept, the largest.
SOUND = 3
#: In the place of seconds: all that follows is the engine's.
ENGINE = "engine"
#: Values that readers trip over.
ODD = (None, True, 0, -1, 1, 1e308, 1e-308, 2**63, 10**40, "", "\x00", "é", "1e999", [], {}, [[]], 0.1)


def odd_json(content: bytes, most: int, seed: int) -> bytes:
    """A content with one value of its JSON exchanged, left out or doubled; or some of its bytes changed."""
    rng = random.Random(seed)
    try:
        document = json.loads(content)
        if rng.random() < 0.3 or not isinstance(document, (dict, list)):
            raise ValueError
        places = [(document, key) for key in _keys(document)]
        for inner, key in places:
            places += [(inner[key], deeper) for deeper in _keys(inner[key])]
        within, key = rng.choice(places)
        match rng.randrange(4):
            case 0:
                del within[key]
            case 1:
                other, there = rng.choice(places)
                within[key] = other[there]
            case 2 if isinstance(within, list):
                within.insert(key, within[key])
            case _:
                within[key] = rng.choice(ODD)
        made = json.dumps(document).encode()
    # A value may now hold itself.
    except (ValueError, IndexError, RecursionError):
        return bytes(atheris.Mutate(content, most))
    return made[:most]


def _keys(document: object) -> list[Any]:
    if isinstance(document, dict):
        return list(document)
    return list(range(len(document))) if isinstance(document, list) else []


def run_engine(name: str, options: list[str]) -> None:
    """Run the engine in this process, which ends with it."""
    reader = READERS[name]
    # The engine's own limit counts what the process had before it became this program.
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MB << 20, MOST_MB << 20))
    limits = [f"-max_len={MOST_BYTES}", f"-timeout={MOST_S}", "-rss_limit_mb=0"]
    # By its first argument the engine starts itself again.
    again = f"{sys.executable} -m kit.fuzzing {name} {ENGINE}"
    atheris.Setup([again, *limits, *options], lambda content: reader.takes(content) and None, custom_mutator=odd_json)
    atheris.Fuzz()


def keep(name: str, folder: Path) -> None:
    """Replace the kept corpus by the least contents that reach as much."""
    least = folder.with_name(f"{folder.name}.least")
    least.mkdir()
    command = [sys.executable, "-m", "kit.fuzzing", name, ENGINE, "-merge=1", str(least), str(folder)]
    subprocess.run(command, check=True)
    # The engine does not see what reaches more code of compiled packages: sound contents are kept in any case.
    sound = (path for path in folder.iterdir() if READERS[name].takes(path.read_bytes()))
    for path in sorted(sound, key=lambda path: path.stat().st_size)[-SOUND:]:
        shutil.copy(path, least)
    CORPORA.mkdir(exist_ok=True)
    with zipfile.ZipFile(CORPORA / f"{name}.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(least.iterdir()):
            archive.write(path, path.name)


def main() -> None:
    """Fuzz, and keep what was found if that is asked for."""
    name, seconds, *more = sys.argv[1:]
    if seconds == ENGINE:
        run_engine(name, more)
    folder = Path(more[0])
    folder.mkdir(exist_ok=True)
    for one, content in kept_corpus(name).items():
        (folder / one).write_bytes(content)
    if "--keep" in more:
        keep(name, folder)
        return
    run_engine(
        name, [f"-max_total_time={seconds}", f"-artifact_prefix={folder}.fault-", "-print_final_stats=1", str(folder)]
    )


if __name__ == "__main__":
    main()
