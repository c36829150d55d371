"""A step that reads a builder's photos and films, done by a sealed process in a folder of its own.

The process gets the films, and copies of the files that the step needs.  Of what it leaves in its folder, the files
that the step makes are taken over, and no others: what was printed before stays as it is.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec

from moireid.bringup.bring_up import STEPS, BuildStep
from moireid.bringup.build_folder import BADGE_JSON, CAMERA, BuildFolder, BuildState, Reading
from moireid.bringup.chart_steps import CHART_FILES, PRINTER, SHEET
from moireid.files import read_regular, whole_file
from moireid.reading.answers import FilmAnswer, checked
from moireid.reading.film_orders import Ask, Progress, Send
from moireid.reading.film_reader import Reader, named

#: Files of earlier steps that a step may need.
OWN = (*CHART_FILES, SHEET, PRINTER, CAMERA, BADGE_JSON)
#: No file that a step makes has more: the films of a record take 0.4 MB.
MOST_BYTES = 50_000_000
#: What reads films, given them and `folder`, in which it may write.
Readers = Callable[..., AbstractContextManager[Reader]]


def send_step(send: Send, ask: Ask, progress: Progress, *, step: str, folder: Path, state: bytes) -> None:
    """Do a step in a folder, and send what it read; state: `BuildState` as JSON."""
    opened = BuildFolder(folder, msgspec.json.decode(state, type=BuildState))
    (wanted,) = (one for one in STEPS if one.name == step)
    send({"result": msgspec.to_builtins(wanted.do(opened, progress))})


def do_sealed(step: BuildStep, folder: BuildFolder, progress: Progress | None, readers: Readers) -> Reading:
    """What a step reads, and the files that it makes, in the builder's folder.

    Raises: MoireIdError as the step does; MediaError where the process fails, or answers what no step does.
    """
    media = {name: path.absolute() for choice in step.needs for name in choice if (path := folder.found(name))}
    if not media:
        return step.do(folder, progress)
    films, lens = list(media.values()), Path(folder.wish.lens)
    read = [*films, lens] if lens.suffix.lower() == ".json" else films
    with TemporaryDirectory(prefix="moireid-") as place:
        aside = Path(place).resolve()
        for name in OWN:
            if folder.at(name).is_file():
                (aside / name).parent.mkdir(exist_ok=True)
                shutil.copyfile(folder.at(name), aside / name)
        state = msgspec.structs.replace(folder.state, files={name: str(path) for name, path in media.items()})
        order = partial(send_step, step=step.name, folder=aside, state=msgspec.json.encode(state))
        with readers(read, folder=aside) as reader:
            said: dict[str, Any] = reader.read(order, progress or (lambda done, of: None))
        reading = checked(checked(said, FilmAnswer, named(films)).result, Reading, named(films))
        _take_over(step, aside, folder)
    return reading


def _take_over(step: BuildStep, aside: Path, folder: BuildFolder) -> None:
    """Copy the files that a step made, and no others; a link is none of them."""
    for name in step.made:
        if (aside / name).is_file() and not (aside / name).is_symlink():
            content = read_regular(aside / name, MOST_BYTES)
            with whole_file(folder.at(name)) as new:
                new.write_bytes(content)
