"""Many films by the engine of collections, and the list of them that `moireid evaluate` reads.

Convention: a film is made in a folder of the worker's own and travels whole, so workers need no folder in common with
this program.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from moireid.archive.engine import Task, run_tasks
from moireid.archive.isolated import Lost
from moireid.badge import Badge
from moireid.bench.rows import LIMITS, Where
from moireid.errors import MoireIdError
from moireid.files import planned, whole_file, write_text
from moireid.kept import keep_row, kept_rows, program_digest
from moireid.simulate.film import truth_path
from moireid.simulate.wish import Wish, filmed, scene_of

MANIFEST, KEPT, COURSE = "films.csv", "made.jsonl", "motion.csv"


@dataclass(frozen=True)
class Planned:
    """One film of a set: the name of its file without a suffix, whose badge, how, and its group in the list.

    course: the content of the CSV file that `wish.motion` names, None where it is a name.
    """

    name: str
    badge: Badge
    wish: Wish
    group: str = ""
    course: bytes | None = None


def make_film_set(
    films: Sequence[Planned], folder: Path, *, where: Where, overwrite: bool = False,
    progress: Callable[[int, int, int, int], None] | None = None,
) -> Path:  # fmt: skip
    """Make all films of a set into a folder, with their truth, their badges and the list `films.csv`.

    Parameters: progress: told (films done, of, failed, made by an earlier run).  A film that is there as it is asked
        for, by this program, is not made again.
    Returns: the list.
    Raises: SpecError where a file exists that is not of this set; MoireIdError where a film cannot be made, once the
        others are; the list is not written then.
    """
    keys, kept = [_key(one) for one in films], folder / KEPT
    rows = {key: row for key, row in kept_rows(kept).items() if (folder / row["video"]).exists()}
    todo = [place for place, key in enumerate(keys) if key not in rows]
    videos = [folder / f"{films[place].name}.mp4" for place in todo]
    planned([*videos, *map(truth_path, videos)], overwrite=overwrite)
    planned([folder / MANIFEST], overwrite=overwrite or bool(rows))
    failed: list[str] = []
    tasks = [Task((films[place],)) for place in todo]
    running = run_tasks(made, tasks, scheduler=where.scheduler, workers=where.workers, limits=LIMITS)
    with closing(running) as ended:
        for count, (at, done) in enumerate(ended, start=1):
            film, (told,) = films[todo[at]], done.outcomes
            if isinstance(told, Lost):
                told = {"error": told.why}
            if "error" not in told:
                _write(videos[at], told)
                rows[keys[todo[at]]] = {"video": videos[at].name, "label": told["label"]}
                keep_row(kept, keys[todo[at]], rows[keys[todo[at]]])
            else:
                failed.append(f"{film.name} ({told['error']})")
            if progress:
                progress(len(films) - len(todo) + count, len(films), len(failed), len(films) - len(todo))
    if failed:
        raise MoireIdError(
            f"{len(failed)} of {len(films)} films cannot be made, first {failed[0]}; mend the plan and run again, "
            "the others are kept"
        )
    write_text(folder / MANIFEST, _manifest(films, [rows[key] for key in keys], folder))
    return folder / MANIFEST


def made(film: Planned) -> dict[str, Any]:
    """One film with its truth, whole, or the sentence for why not; done by a process of the engine."""
    with tempfile.TemporaryDirectory() as folder:
        video, wish = Path(folder) / "film.mp4", film.wish
        if film.course is not None:
            (Path(folder) / COURSE).write_bytes(film.course)
            wish = replace(wish, motion=str(Path(folder) / COURSE))
        try:
            report = filmed(scene_of(film.badge, wish), wish, video)
        except MoireIdError as error:
            # A folder drawn anew each time tells nobody anything.
            return {"error": " ".join(str(error).split()).replace(wish.motion, film.wish.motion)}
        return {"video": video.read_bytes(), "truth": report.truth.read_bytes(), "label": report.label}


def _write(video: Path, told: dict[str, Any]) -> None:
    """The truth first: a film that is there has its truth beside it."""
    for path, content in ((truth_path(video), told["truth"]), (video, told["video"])):
        with whole_file(path) as temporary:
            temporary.write_bytes(content)


def _key(film: Planned) -> str:
    """What names a film: all that it depends on, the program among it."""
    told = (film.name, film.badge.to_json(), asdict(film.wish), program_digest("simulate"))
    course = hashlib.sha256(film.course or b"").hexdigest()
    return hashlib.sha256(json.dumps([told, course], sort_keys=True).encode()).hexdigest()


def _manifest(films: Sequence[Planned], rows: Sequence[dict[str, str]], folder: Path) -> str:
    """The list as text; badges are written beside the films, each once."""
    text, names = io.StringIO(), dict[str, str]()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(("video", "label", "claim", "group"))
    for film, row in zip(films, rows, strict=True):
        badge = film.badge.to_json()
        if badge not in names:
            names[badge] = f"badge-{len(names) + 1}.json"
            write_text(folder / names[badge], badge)
        lines.writerow((row["video"], row["label"], names[badge], film.group))
    return text.getvalue()
