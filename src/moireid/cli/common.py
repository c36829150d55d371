"""What every command shares: exit codes, errors as one sentence, JSON on stdout, progress on stderr."""

from __future__ import annotations

import functools
import json
import math
import os
import re
import signal
import sys
import threading
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from moireid.errors import MoireIdError, SpecError
from moireid.names import JOINERS

if TYPE_CHECKING:
    from moireid.bringup.build_folder import Figure
    from moireid.fabrication.package import PrintResult
    from moireid.provenance import Standing


class FiniteRange(click.FloatRange):
    """A range of numbers that also refuses NaN, which no comparison would refuse."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number, if it is one."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number


class Parsed(click.ParamType[Any]):
    """A text that a function of the library reads; what it reads already stays."""

    name = "text"

    def __init__(self, read: Callable[[str], Any]) -> None:
        self.read = read

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """What the function returns; its error ends the command, as any other does."""
        try:
            return self.read(value) if isinstance(value, str) else value
        except SpecError as error:
            if ctx and ctx.resilient_parsing:
                return None
            fail(str(error))


class FolderPath(click.Path):
    """A folder for outputs; an empty text is refused, because a path takes it for the present folder."""

    def __init__(self) -> None:
        super().__init__(path_type=Path, file_okay=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The folder, if one is named."""
        if not str(value).strip():
            self.fail("no folder is named; give one, or . for the present folder", param, ctx)
        if "://" in str(value):
            self.fail(f"{value!r} is an address, and outputs go into a folder of this machine", param, ctx)
        return super().convert(value, param, ctx)


class GroupedCommand(click.Command):
    """A command whose help shows its options under headings; groups: their names, without dashes, by heading."""

    def __init__(self, *args: Any, groups: Mapping[str, str], **given: Any) -> None:
        super().__init__(*args, **given)
        self._heading = {f"--{name}": heading for heading, names in groups.items() for name in names.split()}

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each group of options under its heading, in the order of the groups and of their names."""
        groups: dict[str, list[tuple[str, str]]] = {heading: [] for heading in self._heading.values()}
        places = {name: place for place, name in enumerate(self._heading)}
        for param in sorted(self.get_params(ctx), key=lambda param: places.get(param.opts[-1], len(places))):
            if isinstance(param, click.Option) and (record := param.get_help_record(ctx)) is not None:
                groups.setdefault(self._heading.get(param.opts[-1], "Options"), []).append(record)
        for heading, rows in groups.items():
            with formatter.section(heading):
                formatter.write_dl(rows)


ACCEPT, REJECT, BAD_INPUT, INCONCLUSIVE = 0, 1, 2, 3
VERDICT_EXIT = {"accept": ACCEPT, "reject": REJECT, "inconclusive": INCONCLUSIVE}

json_option = click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object on stdout.")
overwrite_option = click.option("--overwrite", is_flag=True, help="Replace files that already exist.")


PAPER, PRINTER_DPI = click.Choice(["a4", "letter", "a3", "sra3", "a2", "a1"]), click.IntRange(72, 9600)


printer_dpi_option = click.option(
    "--printer-dpi",
    type=PRINTER_DPI,
    default=1200,
    metavar="DPI",
    help="The printer's dots per inch.",
)
paper_option = click.option(
    "--paper",
    envvar="MOIREID_PAPER",
    type=PAPER,
    default="a4",
    help="Paper size; from sra3 on, a print shop's.",
)
form_option = click.option(
    "--form",
    type=click.Choice(["dots", "vector"]),
    default="dots",
    help="How the lines are drawn: dots, on the printer's grid; vector, free of it.",
)


def _scale(text: str) -> tuple[float, float]:
    from moireid.designer.order import parse_scale

    return parse_scale(text)


SCALE = Parsed(_scale)
scale_option = click.option(
    "--measured-scale",
    type=SCALE,
    default=(1.0, 1.0),
    show_default=False,
    metavar="X[,Y]",
    help="Measured over stated length of the scale bars of an earlier print, such as 0.9973; corrects the size.",
)
registry_option = click.option(
    "--registry",
    "registry_url",
    metavar="URL|FILE",
    help="The registry: the path of an SQLite file, or an SQLAlchemy URL. Default: that of MOIREID_REGISTRY, else one "
    "in your user data folder.",
)
actor_option = click.option(
    "--actor",
    envvar="MOIREID_ACTOR",
    metavar="NAME",
    help="Who does this, as the registry's log is to name them; default: the account that runs this command.",
)
bundle_option = click.option(
    "--bundle",
    "bundle_path",
    type=click.Path(path_type=Path, dir_okay=False),
    help="A file of `moireid registry publish`, instead of --registry: it needs no network and no access to one.",
)
trust_option = click.option(
    "--trust",
    metavar="FINGERPRINT",
    help="The fingerprint of the registry's authority, as its operator gave it to you; any other is refused. Default: "
    "the one that was seen there first.",
)


def shown(line: str) -> str:
    r"""A line for a terminal: letters that would steer it, end the line or turn it round become `\uXXXX`.

    All that a command prints goes through here, as names, films and the processes that read them are in strangers'
    hands.  The joiners of some scripts stay.
    Convention: the escapes are those of JSON, so a JSON document stays the same document.
    """
    return "".join(letter if _steers_nothing(letter) else json.dumps(letter)[1:-1] for letter in line)


def _steers_nothing(letter: str) -> bool:
    return letter.isprintable() or letter in JOINERS or unicodedata.category(letter) == "Zs"


def echo(line: str = "", *, lead: str = "", colour: str | None = None) -> None:
    """Print one line on stdout.

    Parameters: lead: words of ours before it, bold and in a colour where stdout is a terminal and NO_COLOR is not set.
    """
    plain = colour is None or os.environ.get("NO_COLOR")
    click.echo((lead if plain else click.style(lead, fg=colour, bold=True)) + shown(line))


def echo_lines(text: str) -> None:
    """Print a text whose line ends are our own on stdout; where they may be a stranger's, print each line by `echo`."""
    for line in text.split("\n"):
        echo(line)


def show_figures(figures: Iterable[Figure]) -> None:
    """Print figures with their error bars, and what to do about those that are not good."""
    for figure in figures:
        echo(f" {'!' if figure.advice else ' '} {figure.name:<20} {figure.shown}")
        if figure.advice:
            echo_lines(click.wrap_text(f"{figure.words} {figure.advice}", 100, "     ", "     "))


def fail(message: str) -> NoReturn:
    """Say one sentence on stderr and leave with exit code 2."""
    say(f"error: {message}")
    sys.exit(BAD_INPUT)


def friendly(command: Callable[..., Any]) -> Callable[..., Any]:
    """Turn errors into one sentence and exit code 2; no traceback is shown unless MOIREID_TRACEBACK is set."""

    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> Any:
        if os.environ.get("MOIREID_TRACEBACK"):
            return command(*args, **kwargs)
        try:
            return command(*args, **kwargs)
        except (BrokenPipeError, click.exceptions.Exit, click.ClickException, click.Abort):
            raise
        except MoireIdError as error:
            fail(" ".join(str(error).split()))
        except OSError as error:
            name = f" ({error.filename})" if error.filename else ""
            fail(f"the system says: {error.strerror or error}{name}; check the path, the rights and the free space")
        except MemoryError:
            fail("there is not enough memory for this; use a shorter film or a smaller badge")
        # Only here is every error caught: a user must get a sentence, whatever went wrong.
        except Exception as error:  # noqa: BLE001
            kind = type(error).__name__
            words = " ".join(str(error).split())[:300]
            fail(f"something went wrong inside moireid ({kind}: {words}); set MOIREID_TRACEBACK=1 and report it")

    return wrapped


def show_json(document: dict[str, Any]) -> None:
    """Print one JSON object on stdout."""
    ascii_only = (getattr(sys.stdout, "encoding", None) or "utf-8").lower().replace("-", "") != "utf8"
    echo(json.dumps(document, ensure_ascii=ascii_only, allow_nan=False))


def say(message: str) -> None:
    """Print a message for people, one line, on stderr; where that cannot be written, the answer counts all the same."""
    try:
        click.echo(shown(in_options(message)), err=True)
    except OSError:
        # Python flushes it at exit, and would change the exit code where that fails.
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115


def in_options(sentence: str) -> str:
    """A sentence of the library with the options of the command that runs.

    The library names parameters, as `overwrite=True`, `range_m=` or `(size_mm)`; their options are not always alike.
    """
    context = click.get_current_context(silent=True)
    for param in context.command.params if context else ():
        if isinstance(param, click.Option):
            option = param.opts[0]
            name = f"(?:{param.name}|{option.strip('-').replace('-', '_')})"
            sentence = re.sub(rf"\b{name}=(True\b|(?=[ ,;]|$))|(?<=\(){name}(?=\))", option, sentence)
            sentence = re.sub(rf"\b{name}=(?=\S)", f"{option} ", sentence)
    return sentence


def counted(count: int, thing: str) -> str:
    """A number and its thing, in the plural where it needs one: "1 badge", "2 badges"."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def report_mount(made: PrintResult) -> None:
    """Say on stderr which of the two mounts was not made and why, and what became of files of before."""
    names = {"printed": "3D-printed mount", "acrylic": "acrylic stack"}
    for shop, why in made.left_out.items():
        say(f"note: no {names[shop]} was made: {why}")
    for path in made.removed:
        say(f"note: {path} was removed, as it belonged to the badge that was here before")
    for old, new in made.moved_aside.items():
        say(f"note: {old} was of another badge, and is now {new}")


def shown_rows(rows: Iterable[tuple[str, str]]) -> str:
    """Figures of a design as a table, an empty line before it."""
    return "\n".join(["", *(f"  {what:<26} {figure}" for what, figure in rows)])


def report_standing(standing: Standing) -> None:
    """Say on stderr what a user should know about the registry that was asked."""
    for note in standing.notes:
        say(f"note: {note}")


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[int, int | None], None]]:
    """A progress bar on stderr, called with (done, of); silent where stderr is no terminal.

    An interrupt is raised at once, and again at the next step: compiled code that calls back may swallow it.
    """
    with interrupts() as check:
        if not sys.stderr.isatty():
            yield lambda done, total: check()
            return
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(label, total=None)

            def step(done: int, total: int | None) -> None:
                check()
                bar.update(task, completed=done, total=total)

            yield step


@contextmanager
def status_line() -> Iterator[Callable[[str], None]]:
    """A line on stderr that says what is being done, and goes away; interrupts and no terminal as in `progress_bar`."""
    with interrupts() as check:
        if not sys.stderr.isatty():
            yield lambda words: check()
            return
        from rich.console import Console

        with Console(stderr=True).status("") as status:

            def update(words: str) -> None:
                check()
                status.update(words)

            yield update


@contextmanager
def interrupts() -> Iterator[Callable[[], None]]:
    """A check that raises KeyboardInterrupt if one came before and was lost.

    An error after an interrupt counts as the interrupt: a package interrupted while it loads says that it is missing.
    """
    # A shell may make a background job ignore interrupts; and only the main thread can set how they are handled.
    elsewhere = threading.current_thread() is not threading.main_thread()
    if elsewhere or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield lambda: None
        return
    came = False

    def note(number: int, frame: Any) -> None:
        nonlocal came
        came = True
        raise KeyboardInterrupt

    def check() -> None:
        if came:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, note)
    try:
        yield check
    except Exception:
        check()
        raise
    finally:
        signal.signal(signal.SIGINT, before)


track_option = click.option(
    "--track",
    type=click.IntRange(0),
    metavar="N",
    help="The video track to judge, by its number in the file; a film of several tracks is inconclusive without it.",
)
focal_option = click.option(
    "--focal-px",
    type=FiniteRange(50, 100000),
    metavar="PX",
    help="The camera's focal length in pixels, if known; else it is estimated.",
)
camera_option = click.option(
    "--camera",
    "camera_file",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="A calibration of the camera: a file of OpenCV (YAML, XML, JSON) or a lens profile of gyroflow. Then nothing "
    "of the camera is estimated from the film.",
)


def camera_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options of the film's camera, and hand it what they say as `camera`, None for nothing."""

    @functools.wraps(command)
    def wrapped(*args: Any, focal_px: float | None, camera_file: Path | None, **given: Any) -> Any:
        from moireid.question import KnownCamera

        camera = None if focal_px is None else KnownCamera(focal_px)
        if camera_file is not None:
            from moireid.verifier.camera.known_camera import load_camera

            if camera is not None:
                raise SpecError("--camera holds the focal length; leave --focal-px out")
            camera = load_camera(camera_file)
        return command(*args, camera=camera, **given)

    return focal_option(camera_option(wrapped))
