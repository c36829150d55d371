"""Many films by the engine of collections, and the list of them that `moireid lab evaluate` reads.

Convention: a worker makes a film in its own folder and sends it back whole, so workers need no shared folder.
"""

from __future__ import annotations

import hashlib
import json
import tempfile
from base64 import b64decode, b64encode
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.errors import MoireIdError
from moireid.files import planned, whole_file, write_text
from moireid.result_cache import keep_row, kept_rows, program_digest
from moireid.simulate.film_badge import simulate
from moireid.simulate.filming import truth_path
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import LostJob
from moireid_lab.bench.bench_rows import LIMITS, Where
from moireid_lab.evaluation.csv_lists import csv_text

MANIFEST, KEPT, COURSE = "films.csv", "made.jsonl", "motion.csv"


@dataclass(frozen=True)
class PlannedFilm:
    """One film of a set: the name of its file without a suffix, whose badge, how, and its group in the list.

    wish: parameters of `simulate`; course: the content of the CSV file that its motion names, None where it is a name.
    """

    name: str
    badge: Badge
    wish: dict[str, Any]
    group: str = ""
    course: bytes | None = None


def make_film_set(
    films: Sequence[PlannedFilm],
    folder: Path,
    *,
    where: Where,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make all films of a set into a folder, with their truth, their badges and the list `films.csv`.

    Parameters: progress: called with (films done, of).  A film that is there as this program
        made it for the same line is not made again.
    Returns: the list.
    Raises: SpecError where a file exists that is not of this set; MoireIdError where a film cannot be made, once the
        others are.  There is no list then.
    """
    keys, kept = [_key(one) for one in films], folder / KEPT
    rows = kept_rows(kept)
    files = [_files(film, folder) for film in films]
    ours = [rows.get(film.name, {}).get("key") == key for film, key in zip(films, keys, strict=True)]
    todo = [k for k, own in enumerate(ours) if not (own and all(path.is_file() for path in files[k]))]
    planned([folder / MANIFEST], overwrite=overwrite or any(ours))
    # Files of an interrupted run belong to this set too.
    planned((path for k in todo if not ours[k] for path in files[k]), overwrite=overwrite)
    badges = {one.badge.to_json(): folder / _badge_name(one.badge) for one in films}
    others = (path for text, path in badges.items() if not path.is_file() or path.read_text(encoding="utf-8") != text)
    planned(others, overwrite=overwrite)
    # An earlier list is wrong from here on, so it is removed.
    (folder / MANIFEST).unlink(missing_ok=True)
    for text, path in badges.items():
        write_text(path, text)
    failed: list[str] = []
    tasks = [Task((films[place],)) for place in todo]
    running = run_tasks(made, tasks, scheduler=where.scheduler, workers=where.workers, limits=LIMITS)
    with closing(running) as ended:
        for count, (at, done) in enumerate(ended, start=1):
            film, key, (found,) = films[todo[at]], keys[todo[at]], done.outcomes
            if isinstance(found, LostJob):
                found = {"error": found.why}
            if "error" not in found:
                # What is there afterwards is of this film, or missing.
                for path in files[todo[at]]:
                    path.unlink(missing_ok=True)
                rows[film.name] = {"key": key, "label": found["label"]}
                keep_row(kept, film.name, rows[film.name])
                for path, content in zip(files[todo[at]], (found["truth"], found["video"]), strict=True):
                    with whole_file(path) as temporary:
                        temporary.write_bytes(b64decode(content))
            else:
                failed.append(f"{film.name} ({found['error']})")
            if progress:
                progress(len(films) - len(todo) + count, len(films))
    if failed:
        raise MoireIdError(
            f"{len(failed)} of {len(films)} films cannot be made, first {failed[0]}; the others are kept, so fix what "
            "is wrong and run again"
        )
    write_text(folder / MANIFEST, _manifest(films, [rows[film.name]["label"] for film in films]))
    return folder / MANIFEST


def made(film: PlannedFilm) -> dict[str, Any]:
    """One whole film with its truth, or a sentence why it failed; runs in a process of the engine."""
    with tempfile.TemporaryDirectory() as folder:
        video, wish = Path(folder) / "film.mp4", film.wish
        if film.course is not None:
            (Path(folder) / COURSE).write_bytes(film.course)
            wish = wish | {"motion": str(Path(folder) / COURSE)}
        try:
            report = simulate(film.badge, video, **wish)
        except MoireIdError as error:
            # The temporary folder's name is random, so it is left out of the message.
            return {"error": " ".join(str(error).split()).replace(f"{folder}/{COURSE}", str(film.wish.get("motion")))}
        files = {"video": video, "truth": report.truth}
        # What comes out of the process is JSON.
        return {name: b64encode(path.read_bytes()).decode() for name, path in files.items()} | {"label": report.label}


def _files(film: PlannedFilm, folder: Path) -> tuple[Path, Path]:
    """The files of a film; the truth first, so that each finished film has its truth."""
    video = folder / f"{film.name}.mp4"
    return truth_path(video), video


def _badge_name(badge: Badge) -> str:
    """A file name made from the badge's content, so that two files with one name are always equal."""
    return f"badge-{hashlib.sha256(badge.to_json().encode()).hexdigest()[:12]}.json"


def _key(film: PlannedFilm) -> str:
    """The key of a film: all that it depends on, including the program."""
    parts = (film.name, film.badge.to_json(), film.wish, program_digest("simulate"))
    course = hashlib.sha256(film.course or b"").hexdigest()
    return hashlib.sha256(json.dumps([parts, course], sort_keys=True).encode()).hexdigest()


def _manifest(films: Sequence[PlannedFilm], labels: Sequence[str]) -> str:
    """The list as text."""
    rows = [
        (f"{film.name}.mp4", label, _badge_name(film.badge), film.group)
        for film, label in zip(films, labels, strict=True)
    ]
    return csv_text(("video", "label", "claim", "group"), rows)
