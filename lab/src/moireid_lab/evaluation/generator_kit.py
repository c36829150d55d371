"""What a user of a video generator needs to make forged films of a badge.

`cut` takes the first frame of each genuine film of a list at the sizes in which generators work, writes a prompt for
each way in which a badge can come to move, a table of the clips to be made, and the list for `moireid lab evaluate`, to
which the clips that are kept are added.

Convention: paths in the kit are relative to it, so that it can be moved with its films.
Source: the three paradigms and the generators' formats are those of the published collection (Qing et al. 2026); the
words of the prompts are ours.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError, SpecError
from moireid.files import planned, whole_file, write_text
from moireid.verifier.video import Film
from moireid_lab.evaluation.csv_lists import csv_text
from moireid_lab.evaluation.manifest import Entry, Manifest

#: Width, height and frames per second.
FORMATS = {"848x480": (848, 480, 24), "1280x720": (1280, 720, 24), "1920x1080": (1920, 1080, 25)}
ONE_TAKE = (
    "One continuous shot that begins with this picture, without a cut. People, clothes, badge and room stay as they "
    "are, and the badge stays sharp and wholly in view. The dark bands on it shift as the angle of view changes."
)
#: By name: the paradigm, and what moves how.  A sweep to one side is what the published prompts ask for; a motion to
#: and fro is what a film must have if delay and drift are to be detected.
PROMPTS = {
    "camera-sweep": ("camera moves", "The badge is at rest. The camera glides level to one side at an even pace."),
    "camera-fro": (
        "camera moves",
        "The badge is at rest. The camera glides level to the left, back to the right, and on.",
    ),
    "board-sweep": ("board moves", "The camera is at rest. The badge is carried level to one side at an even pace."),
    "board-fro": (
        "board moves",
        "The camera is at rest. The badge is carried level to the left, back to the right, and on.",
    ),
    "both-sweep": (
        "both move",
        "The camera glides level to one side as the badge is carried to the other, both evenly.",
    ),
    "both-fro": ("both move", "Camera and badge move level against each other, to and fro, each at its own pace."),
}
CLIPS, PROMPT_FILE, MANIFEST = "clips.csv", "prompts.csv", "films.csv"
COLUMNS = ("clip", "frame", "width", "height", "fps", "paradigm", "prompt", "claim")


def cut(manifest: Manifest, base: str, folder: Path, *, formats: Sequence[str], overwrite: bool) -> list[Path]:
    """Make the kit of a list's genuine films.

    Parameters: base: path of the list; formats: of `FORMATS`.
    Returns: the files, pictures first.
    Raises: SpecError where the list has no genuine film or a file exists; MediaError where a film cannot be read.
    """
    entries = [entry for entry in manifest.entries if entry.genuine]
    if not entries:
        raise SpecError("the list has no genuine film, so there is nothing to cut frames out of; add one")
    pictures = {
        (entry.line, name): folder / "frames" / f"{entry.line:04d}-{name}.png" for entry in entries for name in formats
    }
    texts = [folder / name for name in (PROMPT_FILE, CLIPS, MANIFEST)]
    planned([*pictures.values(), *texts], overwrite=overwrite)
    (folder / "clips").mkdir(exist_ok=True)
    for entry in entries:
        first = first_picture(Path(entry.video))
        for name in formats:
            with whole_file(pictures[entry.line, name]) as temporary:
                cv2.imwrite(str(temporary), fitted(first, *FORMATS[name][:2]))
    prompts = [(name, paradigm, f"{moves} {ONE_TAKE}") for name, (paradigm, moves) in PROMPTS.items()]
    write_text(texts[0], csv_text(("prompt", "paradigm", "text"), prompts))
    write_text(texts[1], csv_text(COLUMNS, list(_asked(entries, formats, base, folder))))
    write_text(texts[2], _films([_genuine(entry, base, folder) for entry in entries]))
    return [*pictures.values(), *texts]


def first_picture(path: Path) -> NDArray[np.uint8]:
    """The first picture of a film in colour as it is to be shown, (height, width, 3) blue, green, red.

    Convention: turned by the file's rotation flag, and its pixels made square.
    Raises: MediaError where none can be read.
    """
    import av

    Film(path)
    try:
        with av.open(str(path)) as container:
            picture = next(container.decode(video=0))
            aspect = float(container.streams.video[0].sample_aspect_ratio or 1)
            shown = picture.to_ndarray(format="bgr24")
            quarters = round(picture.rotation / 90)
    except (av.error.FFmpegError, StopIteration) as error:
        raise MediaError(f"no picture of {path} can be read; export it as MP4 with H.264") from error
    if aspect != 1.0:
        shown = np.asarray(cv2.resize(shown, None, fx=aspect, fy=1.0), np.uint8)
    return np.ascontiguousarray(np.rot90(shown, quarters))


def fitted(picture: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """The middle of a picture at that size: cut to its shape, then scaled, never stretched."""
    rows, columns = picture.shape[:2]
    scale = max(width / columns, height / rows)
    wide, high = min(round(width / scale), columns), min(round(height / scale), rows)
    x, y = (columns - wide) // 2, (rows - high) // 2
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(picture[y : y + high, x : x + wide], (width, height), interpolation=way), np.uint8)


def _asked(entries: Sequence[Entry], formats: Sequence[str], base: str, folder: Path) -> Iterator[tuple[Any, ...]]:
    """A line of the table for each picture and prompt."""
    for entry in entries:
        for name in formats:
            for prompt, (paradigm, _) in PROMPTS.items():
                clip, frame = f"{entry.line:04d}-{name}-{prompt}.mp4", f"frames/{entry.line:04d}-{name}.png"
                yield clip, frame, *FORMATS[name], paradigm, prompt, _claim(entry, base, folder)


def _genuine(entry: Entry, base: str, folder: Path) -> dict[str, str]:
    """A genuine film's line of the list, as seen from the kit."""
    video = os.path.relpath(entry.video, folder)
    return {
        "video": video,
        "label": "genuine",
        "claim": _claim(entry, base, folder),
        "group": entry.group,
        "corners": "",
    }


def _claim(entry: Entry, base: str, folder: Path) -> str:
    """The claim: a badge's file as seen from the kit, or a name or id as it is."""
    return (
        os.path.relpath(Path(base).parent / entry.claim, folder)
        if entry.claim.lower().endswith(".json")
        else entry.claim
    )


def _films(rows: Sequence[dict[str, str]]) -> str:
    """The list that `evaluate` reads."""
    columns = ("video", "label", "claim", "group", "corners")
    return csv_text(columns, [tuple(row.get(name, "") for name in columns) for row in rows])
