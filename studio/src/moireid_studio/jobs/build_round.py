"""A round of a first badge in a film's own process: `bringup.advance` as it is, in the folder of the build.

The report is made here too: it shows what this process has read, and the studio hands it out as a file in which nothing
runs.
"""

from __future__ import annotations

import os
import re
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from moireid.bringup.build_folder import Figure, Reading, Wish, open_folder
from moireid.files import write_text
from moireid.reading.film_orders import Ask, Progress, Send
from moireid_studio.problems import plain
from moireid_studio.store.build_store import FOLDER, RECORD, ROUND, BuildRound

if TYPE_CHECKING:
    from moireid.bringup.bring_up import Advance

#: What the steps ask for in a folder, as a page asks for it; all are applied.
SENT = (
    (r" \(If you measured the sheet again[^)]*\)", ""),
    (r"Save it as \S+/[\w-]+\.\w+\.", "Send it below."),
    (r": \S+/[\w-]+\.mp4\.", "."),
    (r"\S+/([\w-]+\.pdf)", r"\1"),
)


def advance_build(
    send: Send,
    ask: Ask,
    progress: Progress,
    *,
    place: str,
    wish: dict[str, Any],
    record: dict[str, Any] | None = None,
) -> None:
    """Do what can be done with the pictures that are there.

    Parameters
    ----------
    place
        The folder `work` of the build.
    wish
        All fields of `bringup.build_folder.Wish`, as JSON.
    record
        Write the capture record, with these arguments of `collect_record`; None: write none.
    """
    # Loaded here: few jobs need it.
    from moireid.bringup.badge_steps import collect_record
    from moireid.bringup.bring_up import advance
    from moireid.bringup.capture_record import write_record
    from moireid.bringup.progress_page import PAGE, render_progress

    os.chdir(place)
    # What is not given is forgotten.
    wished = {key: value or 0 for key, value in msgspec.structs.asdict(msgspec.convert(wish, Wish)).items()}
    # A path that is relative is shown as one.
    made = advance(open_folder(Path(FOLDER), wished), watch=lambda _: nullcontext(progress))
    if made.did:
        Path(RECORD).unlink(missing_ok=True)
    write_text(made.folder.at(PAGE), render_progress(in_page_words(made)))
    next_step = None if made.next_step is None else made.next_step.name
    came = BuildRound(list(made.did), next_step, made.refused)
    write_text(Path(ROUND), msgspec.json.encode(came).decode())
    if record is not None:
        write_record(collect_record(made.folder, **record), Path(RECORD))
    send({"result": {"kind": "build"}})


def in_page_words(made: Advance) -> Advance:
    """The same, in the words of a page: no files to save, and no options of a command."""
    readings = {name: _plain_reading(one) for name, one in made.folder.state.readings.items()}
    folder = replace(made.folder, state=msgspec.structs.replace(made.folder.state, readings=readings))
    steps = [replace(step, ask=tuple(map(_sent, step.ask))) for step in made.steps]
    next_step = next((step for step in steps if made.next_step is not None and step.name == made.next_step.name), None)
    refused = None if made.refused is None else _whole(_plain(made.refused))
    return replace(made, folder=folder, steps=steps, next_step=next_step, refused=refused)


def _sent(sentence: str) -> str:
    for pattern, words in SENT:
        sentence = re.sub(pattern, words, sentence)
    return sentence


def _plain(text: str) -> str:
    return plain(text.replace(f"{FOLDER}/", ""))


def _whole(text: str) -> str:
    """An error's words as a sentence of their own; names of files stay as they are."""
    first = text.split(" ")[0]
    return f"{text[:1].upper() if first.isalpha() else text[:1]}{text[1:].rstrip('.')}."


def _plain_reading(reading: Reading) -> Reading:
    refused = None if reading.refused is None else _whole(_plain(reading.refused))
    figures, notes = [_plain_figure(one) for one in reading.figures], [_whole(_plain(note)) for note in reading.notes]
    return msgspec.structs.replace(reading, figures=figures, notes=notes, refused=refused)


def _plain_figure(figure: Figure) -> Figure:
    return msgspec.structs.replace(figure, words=_plain(figure.words), advice=_plain(figure.advice))
