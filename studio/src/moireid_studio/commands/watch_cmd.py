"""watch: is the badge in a stream real, and is it the claimed one?

A running verdict: in the terminal for people, as lines of JSON for programs.
"""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from moireid.cli.common import (
    VERDICT_EXIT,
    FiniteRange,
    actor_option,
    friendly,
    overwrite_option,
    say,
    show_json,
    shown,
)
from moireid.cli.enroll_cmd import check_replace, reason_option, replace_option
from moireid.cli.verify.verify_cmd import asked_of, files_read, show_verdict
from moireid.cli.verify.verify_options import (
    CLAIM_OPTIONS,
    ClaimWish,
    check_claim,
    focal_option,
    level_option,
    original_option,
)
from moireid.errors import SpecError
from moireid.files import read_regular

if TYPE_CHECKING:
    from rich.table import Table

    from moireid.provenance import ClaimedBadge
    from moireid.verifier.report.circumstances import Circumstances
    from moireid.verifier.session.check_level import CheckLevel
    from moireid_studio.watch.source import Source


Send = Callable[[dict[str, Any]], None]
COLOURS = {"accept": "green", "reject": "red", "inconclusive": "yellow"}
#: Findings of a running verdict that are shown.
MOST_FINDINGS = 4


def json_line(event: dict[str, Any]) -> None:
    """One object a line on stdout, at once."""
    show_json(event)
    sys.stdout.flush()


@contextmanager
def live_display(shown: str) -> Iterator[Send]:
    """A table on stderr that changes as it goes; without a terminal a line where something changes."""
    if not sys.stderr.isatty():
        yield _Lines().show
        return
    from rich.console import Console
    from rich.live import Live

    panel = _Panel(shown)
    with Live(panel.table(), console=Console(stderr=True), refresh_per_second=8, transient=True) as live:

        def show(event: dict[str, Any]) -> None:
            if (line := line_of(event)) is not None:
                live.console.print(f"{panel.elapsed}  {line}", markup=False, highlight=False)
            panel.take(event)
            live.update(panel.table())

        yield show


def line_of(event: dict[str, Any]) -> str | None:
    """An event in a line; None for a running verdict."""
    kind = event["event"]
    if kind == "waiting":
        token = f" with the bearer token {event['token']}" if event.get("token") else ""
        clear = "" if event["here"] else "; without HTTPS in front, others can read the token on its way"
        return f"waiting for a sender (WHIP) at {event['address']}{token}{clear}"
    if kind == "begun":
        return f"pictures of {event['width']} x {event['height']}; Ctrl-C gives the verdict"
    if kind == "challenge":
        return f"{event['moves']} moves will be asked for; hold the badge still until the first"
    if kind == "prompt":
        return plain(f"{event['number']} of {event['of']}: {event['text']}")
    if kind == "prompted":
        return plain(f"{event['number']}: {event['reason']['text']}")
    return plain(event["text"]) if kind == "anew" else None


def plain(text: object) -> str:
    """Words without signs that steer a terminal."""
    return shown(str(text)[:400])


class _Lines:
    """What changes, line by line."""

    def __init__(self) -> None:
        self._begun, self._verdict = time.monotonic(), ""

    def show(self, event: dict[str, Any]) -> None:
        line = line_of(event)
        if event["event"] == "status" and event["verdict"] != self._verdict:
            self._verdict = event["verdict"]
            line = f"{plain(self._verdict)}: {plain(first_of(event))}"
        if line is not None:
            say(f"{time.monotonic() - self._begun:6.1f} s  {line}")


def first_of(event: dict[str, Any]) -> str:
    """The finding that a running verdict hangs on."""
    wanted = {"reject": ("fail",), "inconclusive": ("undecided", "fail")}.get(event["verdict"], ("pass",))
    found = [one["text"] for level in wanted for one in event["reasons"] if one["level"] == level]
    return str(found[0]) if found else ""


class _Panel:
    """The running verdict as a table."""

    def __init__(self, shown: str) -> None:
        self._shown, self._begun, self._status = shown, time.monotonic(), dict[str, Any]()

    @property
    def elapsed(self) -> str:
        return f"{time.monotonic() - self._begun:6.1f} s"

    def take(self, event: dict[str, Any]) -> None:
        if event["event"] == "status":
            self._status = event

    def table(self) -> Table:
        from rich.markup import escape
        from rich.table import Table

        table = Table.grid(padding=(0, 2))
        verdict = str(self._status.get("verdict", ""))
        colour = COLOURS.get(verdict, "white")
        words = escape(plain(verdict)) if verdict else "looking"
        table.add_row(f"[bold {colour}]{words.upper()}[/]", f"the last seconds of {escape(plain(self._shown))}")
        if self._status:
            seen = "the badge is in view" if self._status.get("badge") else "no badge is in view"
            table.add_row("", f"{seen}; {int(self._status.get('tracked', 0))} pictures of it are judged")
        for one in self._weightiest():
            table.add_row("", escape(plain(one["text"])))
        return table

    def _weightiest(self) -> list[dict[str, Any]]:
        order = {"fail": 0, "undecided": 1, "pass": 2}
        found = [one for one in self._status.get("reasons", ()) if one["level"] in order]
        return sorted(found, key=lambda one: order[one["level"]])[:MOST_FINDINGS]


#: Least letters of a token, so that it cannot be guessed.
LEAST_TOKEN = 12
OPTIONS = (
    *CLAIM_OPTIONS,
    click.option(
        "--challenge",
        is_flag=True,
        help="Ask for moves, drawn at random, when each is due; who films must follow them. Needs moireid[face].",
    ),
    click.option(
        "--seconds",
        type=FiniteRange(1, 7 * 86400),
        default=3600,
        show_default=True,
        metavar="S",
        help="Give the verdict after so many seconds of pictures at most.",
    ),
    click.option(
        "--cover",
        "cover_share",
        type=click.FloatRange(0, 1),
        default=0.5,
        show_default=True,
        metavar="SHARE",
        help="Share of the stream that the last verdict must be of, 0 to 1; with less it is inconclusive.",
    ),
    original_option,
    level_option,
    click.option(
        "--enroll",
        is_flag=True,
        help="With --challenge: keep what an accepted check measured of the badge as its figures of enrolment, with "
        "the note that it followed prompts. The registry must hold the badge.",
    ),
    replace_option,
    reason_option,
    actor_option,
    click.option(
        "--receipt",
        "receipt_file",
        type=click.Path(path_type=Path, dir_okay=False),
        help="With --challenge: write here who was checked, when, and what came out, for moireid verify --live-check.",
    ),
    overwrite_option,
    click.option(
        "--about",
        type=click.Path(path_type=Path, dir_okay=False, exists=True),
        metavar="FILM",
        help="With --receipt: the film that the person is asked about; the receipt names it by its SHA-256.",
    ),
    focal_option,
    click.option(
        "--token-file",
        type=click.Path(path_type=Path, dir_okay=False),
        help="The token that a sender to whip:// must show, or that a whep:// server asks for. Default for whip://: "
        "one is drawn and printed.",
    ),
    click.option(
        "--json",
        "as_json",
        is_flag=True,
        help="Print one JSON object a line as it goes; the last one as `moireid verify --json` does.",
    ),
)


@dataclass(frozen=True)
class WatchWish(ClaimWish):
    """What was asked for, as it was typed; the names are those of the options."""

    source: str
    challenge: bool
    seconds: float
    cover_share: float
    require_original: bool | None
    level: CheckLevel
    enroll: bool
    replace: bool
    reason: str | None
    actor: str | None
    receipt_file: Path | None
    overwrite: bool
    about: Path | None
    focal_px: float | None
    token_file: Path | None
    as_json: bool


def _options(command: Any) -> Any:
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@click.command("watch")
@click.argument("source")
@_options
@friendly
def watch_command(**given: Any) -> None:
    """Check a camera, a stream or a call as it comes.

    The verdict on the last seconds is shown as it goes. Ctrl-C, or the end of the stream, gives the verdict on all of
    it. Say whose badge it should be with --claim, or give its file with --badge.

    \b
    SOURCE is one of:
      0                         a camera of this machine, by its number
      film.ts                   a film; one that grows is followed while it does
      -                         a pipe: cat film.ts | moireid watch - --claim Ada
      rtsp://camera/1           a network camera
      https://host/live.m3u8    a stream (HLS), or a film on the web
      whep://host/room          a WebRTC stream; wheps:// with encryption
      whip://127.0.0.1:8080     wait for a WebRTC sender, such as OBS
      screen                    this screen (Linux with X11 alone)
      screen:0x3a00007          one window, by the number that xwininfo shows

    An address is opened because you name it. What it names in turn is opened only on the same host or on the public
    internet. Strangers' pictures are read in a process of their own.

    Exit code of the last verdict: 0: accepted; 1: rejected; 3: inconclusive. 2: bad input, or no picture came.
    """
    from moireid.verifier.report.live_receipt import film_asked
    from moireid_studio.commands.watch_kept import check_enrollable, enroll, write_receipt
    from moireid_studio.watch.source import check_prompts, source_of

    wish = WatchWish(**given)
    check_claim(wish)
    _check_kept(wish)
    film = film_asked(wish.about) if wish.about is not None else None
    if film is not None:
        say(
            f"about the film {film.name}: let the person follow the prompts only if it is theirs and they agree with it"
        )
    source = source_of(wish.source)
    if wish.challenge:
        check_prompts(source)
    token = _token(wish.token_file, source)
    with asked_of(wish) as asked:
        if wish.enroll:
            check_enrollable(asked.found)
        document = _watched(wish, source, token, asked.found)
        known = asked.known(document, wish.claim)
        figures = document.pop("as_built", None)
    if wish.as_json:
        show_json(document)
    else:
        _show(document, known, source)
    if wish.receipt_file is not None:
        write_receipt(wish.receipt_file, document, asked.found, film)
    if wish.enroll:
        measured = figures if document["challenged"] and document["verdict"] == "accept" else None
        enroll(asked.found.badge, measured, wish.registry_url, wish.actor, wish.reason)
    sys.exit(VERDICT_EXIT[document["verdict"]])


def _check_kept(wish: WatchWish) -> None:
    """Raise SpecError where options for what is kept do not go together."""
    from moireid.files import planned

    check_replace(wish.replace, wish.reason, "--enroll", wish.enroll)
    if wish.enroll and not wish.challenge:
        raise SpecError("--enroll keeps what a live check measured; give --challenge too")
    if wish.enroll and (wish.level == "enrolled" or wish.require_original is not None or wish.receipt_file is not None):
        raise SpecError(
            "--enroll measures figures, and compares the badge with none; leave out --level enrolled, "
            "--require-original and --receipt, and make another check for these"
        )
    if wish.about is not None and wish.receipt_file is None:
        raise SpecError("--about FILM is written into a receipt; give --receipt FILE too")
    if wish.receipt_file is not None and not wish.challenge:
        raise SpecError("--receipt is of a live check; give --challenge too")
    if wish.receipt_file is not None:
        planned([wish.receipt_file], overwrite=wish.overwrite, kept=[*files_read(wish), wish.about, wish.token_file])


def _watched(wish: WatchWish, source: Source, token: str | None, found: ClaimedBadge) -> dict[str, Any]:
    """The verdict's document; the claim is this process's own word, and so is the registry."""
    from moireid.sandbox.seal import missing
    from moireid.verifier import Claim
    from moireid_studio.challenge.challenge import draw_prompts
    from moireid_studio.watch.order import WatchOrder
    from moireid_studio.watch.watching import Terms, watch

    prompts = draw_prompts(0.0) if wish.challenge else None
    given = found.without_figures() if wish.enroll else found
    asked = {"focal_px": wish.focal_px, "require_original": wish.require_original, "cover_share": wish.cover_share}
    claim = Claim.of(given, **asked, level=wish.level, enrolling=wish.enroll)
    order = WatchOrder(source, claim, found.barred, prompts)
    with _stopped() as stop, nullcontext(json_line) if wish.as_json else live_display(source.shown) as show:
        document = watch(order, Terms(wish.seconds, token), stop, show)
    sealed = tuple(document["sealed"])
    if (lacking := missing(sealed)) is not None:
        say(f"note: the process that read the stream {lacking}: this system has no means against that")
    standing = found.provenance.standing
    return document | {
        "registry": standing.to_json() if standing else None,
        "claim_source": found.provenance.source,
        "badge": found.to_json(),
        "challenged": prompts is not None and document.get("challenged") is True,
    }


def _token(path: Path | None, source: Source) -> str | None:
    """The token in a file.  Raises: SpecError where it is of no use, or easily guessed."""
    if path is None:
        return None
    if source.kind not in ("whip", "whep"):
        raise SpecError(f"--token-file is for whip:// and whep://, and the source is {source.shown}; leave it out")
    token = read_regular(path).decode("utf-8", errors="replace").strip()
    if len(token) < LEAST_TOKEN or not token.isascii() or not token.isprintable() or " " in token:
        raise SpecError(f"{path} holds no token: one line of {LEAST_TOKEN} or more letters and digits, without blanks")
    return token


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
