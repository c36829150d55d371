"""watch: is the badge in a stream real, and is it the claimed one?

A running verdict: in the terminal for people, as lines of JSON for programs.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import VERDICT_EXIT, FiniteRange, focal_option, friendly, say, show_json
from moireid.cli.verify.verify_cmd import show_verdict
from moireid.cli.verify.verify_options import claim_options, level_option
from moireid_studio.commands.watch_display import LiveLines, json_line

if TYPE_CHECKING:
    from moireid.api.asking import ClaimContext
    from moireid.question import Question
    from moireid.verifier.report.circumstances import Circumstances
    from moireid_studio.watch.source import Source


@click.command("watch")
@click.argument("source")
@friendly
@claim_options
@click.option(
    "--challenge",
    is_flag=True,
    help="Ask for moves, drawn at random, when each is due; who films must follow them. Needs moireid[face].",
)
@click.option(
    "--seconds",
    type=FiniteRange(1, 7 * 86400),
    default=3600,
    metavar="S",
    help="Give the verdict after so many seconds of pictures at most.",
)
@click.option(
    "--cover",
    "cover_share",
    type=click.FloatRange(0, 1),
    default=0.5,
    metavar="SHARE",
    help="Share of the stream that the last verdict must be of, 0 to 1; with less it is inconclusive.",
)
@level_option
@focal_option
@click.option(
    "--json",
    "as_json",
    is_flag=True,
    help="Print one JSON object a line as it goes; the last one as `moireid verify --json` does.",
)
def watch_command(
    source: str, claimed: AbstractContextManager[ClaimContext], challenge: bool, as_json: bool, **wanted: Any
) -> None:
    """Check a camera or a stream as it comes.

    The verdict on the last seconds is shown as it goes. Ctrl-C, or the end of the stream, gives the verdict on all of
    it. Say whose badge it should be with --claim, or give its file with --badge.

    \b
    SOURCE is one of:
      0                         a camera of this machine, by its number
      film.ts                   a film; one that grows is followed while it does
      -                         a pipe: cat film.ts | moireid watch - --claim Ada

    \b
    FFmpeg writes a network camera or a stream on the web into a pipe as it is:
      ffmpeg -i rtsp://cam/1 -c copy -f matroska - | moireid watch - --claim Ada

    OBS shows a screen as a camera. Strangers' pictures are read in a process of their own.

    Exit code of the last verdict: 0: accepted; 1: rejected; 3: inconclusive. 2: bad input, or no picture came.
    """
    from moireid_studio.watch.source import check_prompts, source_of

    stream = source_of(source)
    if challenge:
        check_prompts(stream)
    with claimed as (found, look_up):
        document = _watched(stream, found, wanted, challenge=challenge, as_json=as_json)
        known = look_up(document)
    if as_json:
        show_json(document)
    else:
        _show(document, known, stream)
    sys.exit(VERDICT_EXIT[document["verdict"]])


def _watched(
    source: Source, found: Question, wanted: dict[str, Any], *, challenge: bool, as_json: bool
) -> dict[str, Any]:
    """The verdict's document; the claim is this process's own word, and so is the registry.

    Parameters: wanted: the other options, by name.
    """
    from moireid.question import KnownCamera
    from moireid.sandbox.seal import missing
    from moireid_studio.challenge.challenge import draw_prompts
    from moireid_studio.watch.order import WatchOrder
    from moireid_studio.watch.watching import watch

    prompts = draw_prompts(0.0) if challenge else None
    camera = None if wanted["focal_px"] is None else KnownCamera(wanted["focal_px"])
    question = replace(found, camera=camera, cover_share=wanted["cover_share"], level=wanted["level"])
    order = WatchOrder(source, question, prompts)
    with _stopped() as stop:
        document = watch(order, wanted["seconds"], stop, json_line if as_json else LiveLines().show)
    sealed = tuple(document["sealed"])
    if (lacking := missing(sealed)) is not None:
        say(f"note: the process that read the stream {lacking}: this system has no means against that")
    return document | found.stated() | {"challenged": prompts is not None and document.get("challenged") is True}


@contextmanager
def _stopped() -> Iterator[threading.Event]:
    """Set by the first interrupt, or by SIGTERM; a second interrupt ends the program."""
    stop = threading.Event()

    def note(number: int, frame: Any) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _show(document: dict[str, Any], known: Circumstances, source: Source) -> None:
    """The last verdict; what ended the stream, where it did not end as it should."""
    from moireid_studio.challenge.live_headline import live_headline_of

    if document["end"]["text"]:
        frames = document["frames"]
        say(f"note: {document['end']['text']}; {frames['read']} pictures were read, {frames['tracked']} show the badge")
    live = source.live(challenged=document["challenged"])
    headline = live_headline_of(document, document["badge"]["name"], known) if live else None
    show_verdict(document["verdict"].upper(), document, known, headline)
