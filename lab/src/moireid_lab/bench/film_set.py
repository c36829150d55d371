"""Many films by the engine of collections, and the list of them that `moireid lab evaluate` reads.

Convention: a worker makes a film in its own folder and sends it back whole, so workers need no shared folder.  The
digests of a film are stored before its files are written; later only files with these digests count as made.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import tempfile
from base64 import b64decode, b64encode
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.errors import MoireIdError
from moireid.files import planned, whole_file, write_text
from moireid.result_cache import keep_row, kept_rows, program_digest
from moireid.simulate.filming import FilmOptions, filmed, scene_of, truth_path
from moireid_lab.archive.engine import Task, run_tasks
from moireid_lab.archive.isolated import LostJob
from moireid_lab.bench.bench_rows import LIMITS, Where

MANIFEST, KEPT, COURSE = "films.csv", "made.jsonl", "motion.csv"


@dataclass(frozen=True)
class PlannedFilm:
    """One film of a set: the name of its file without a suffix, whose badge, how, and its group in the list.

    course: the content of the CSV file that `wish.motion` names, None where it is a name.
    """

    name: str
    badge: Badge
    wish: FilmOptions
    group: str = ""
    course: bytes | None = None


def make_film_set(
    films: Sequence[PlannedFilm],
    folder: Path,
    *,
    where: Where,
    overwrite: bool = False,
    progress: Callable[[int, int, int, int], None] | None = None,
) -> Path:
    """Make all films of a set into a folder, with their truth, their badges and the list `films.csv`.

    Parameters: progress: called with (films done, of, failed, made earlier).  A film that is there as this program
        made it for the same line is not made again.
    Returns: the list.
    Raises: SpecError where a file exists that is not of this set; MoireIdError where a film cannot be made, once the
        others are.  There is no list then.
    """
    keys, kept = [_key(one) for one in films], folder / KEPT
    asked = set(keys)
    rows = {key: row for key, row in kept_rows(kept).items() if key in asked and "files" in row}
    todo = [place for place, key in enumerate(keys) if not (key in rows and _as_made(rows[key], folder))]
    planned([folder / MANIFEST], overwrite=overwrite or bool(rows))
    # Files left by an interrupted run belong to this set too.
    ours = {
        path for place in todo for path in _files(films[place], folder) if _digest(path) in _earlier(rows, keys[place])
    }
    planned((path for place in todo for path in _files(films[place], folder) if path not in ours), overwrite=overwrite)
    badges = {one.badge.to_json(): folder / _badge_name(one.badge) for one in films}
    planned((path for text, path in badges.items() if not _holds(path, text)), overwrite=overwrite)
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
                contents = dict(
                    zip(_files(film, folder), map(b64decode, (found["truth"], found["video"])), strict=True)
                )
                rows[key] = {
                    "label": found["label"],
                    "files": {path.name: _hash(one) for path, one in contents.items()},
                }
                keep_row(kept, key, rows[key])
                for path, content in contents.items():
                    with whole_file(path) as temporary:
                        temporary.write_bytes(content)
            else:
                failed.append(f"{film.name} ({found['error']})")
            if progress:
                progress(len(films) - len(todo) + count, len(films), len(failed), len(films) - len(todo))
    if failed:
        raise MoireIdError(
            f"{len(failed)} of {len(films)} films cannot be made, first {failed[0]}; the others are kept, so fix what "
            "is wrong and run again"
        )
    write_text(folder / MANIFEST, _manifest(films, [rows[key]["label"] for key in keys]))
    return folder / MANIFEST


def made(film: PlannedFilm) -> dict[str, Any]:
    """One whole film with its truth, or a sentence why it failed; runs in a process of the engine."""
    with tempfile.TemporaryDirectory() as folder:
        video, wish = Path(folder) / "film.mp4", film.wish
        if film.course is not None:
            (Path(folder) / COURSE).write_bytes(film.course)
            wish = replace(wish, motion=str(Path(folder) / COURSE))
        try:
            report = filmed(scene_of(film.badge, wish), wish, video)
        except MoireIdError as error:
            # The temporary folder's name is random, so it is left out of the message.
            return {"error": " ".join(str(error).split()).replace(wish.motion, film.wish.motion)}
        files = {"video": video, "truth": report.truth}
        # What comes out of the process is JSON.
        return {name: b64encode(path.read_bytes()).decode() for name, path in files.items()} | {"label": report.label}


def _files(film: PlannedFilm, folder: Path) -> tuple[Path, Path]:
    """The files of a film; the truth first, so that each finished film has its truth."""
    video = folder / f"{film.name}.mp4"
    return truth_path(video), video


def _as_made(row: dict[str, Any], folder: Path) -> bool:
    return all(_digest(folder / name) == digest for name, digest in row["files"].items())


def _earlier(rows: dict[str, dict[str, Any]], key: str) -> set[str | None]:
    """The digests of a film's files, if it was made before."""
    return set(rows[key]["files"].values()) if key in rows else set()


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _digest(path: Path) -> str | None:
    """The digest of a file's content; None where there is no file."""
    if not path.is_file():
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _badge_name(badge: Badge) -> str:
    """A file name made from the badge's content, so that two files with one name are always equal."""
    return f"badge-{_hash(badge.to_json().encode())[:12]}.json"


def _holds(path: Path, text: str) -> bool:
    return _digest(path) == _hash(text.encode())


def _key(film: PlannedFilm) -> str:
    """The key of a film: all that it depends on, including the program."""
    parts = (film.name, film.badge.to_json(), asdict(film.wish), program_digest("simulate"))
    course = hashlib.sha256(film.course or b"").hexdigest()
    return hashlib.sha256(json.dumps([parts, course], sort_keys=True).encode()).hexdigest()


def _manifest(films: Sequence[PlannedFilm], labels: Sequence[str]) -> str:
    """The list as text."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(("video", "label", "claim", "group"))
    lines.writerows(
        (f"{film.name}.mp4", label, _badge_name(film.badge), film.group)
        for film, label in zip(films, labels, strict=True)
    )
    return text.getvalue()
