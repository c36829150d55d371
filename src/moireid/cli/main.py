"""The programs `moireid` and `print-your-badge`."""

from __future__ import annotations

import gc
import io
import os
import pkgutil
import sys
from importlib.util import find_spec
from typing import Any, NoReturn

import click

from moireid.cli.common import BAD_INPUT
from moireid.cli.removed import REMOVED, Removed, check_present
from moireid.cli.streams import open_closed_streams
from moireid.extras import install_command
from moireid.version import __version__

#: The sections of `moireid --help`: names of commands, in the order in which people need them, with the sentence that
#: each one's own help begins with; so the list loads none of them.
SECTIONS: dict[str, dict[str, str]] = {
    "Commands that most people need": {
        "print": "Make a badge for NAME, ready to print.",
        "enroll": "Enter a badge into the registry of who holds which badge.",
        "verify": "Check a film: is the badge real, and is it the claimed one?",
        "identify": "Find out whose badge a film shows.",
        "watch": "Check a camera or a stream as it comes.",
        "attest": "Check signed verdicts.",
        "simulate": "Simulate a film of a badge, real or forged.",
        "serve": "Run the studio: web pages and an API for all of this.",
    },
    "Your first badge; what to buy; lens sheets, printers and cameras": {
        "first-badge": "Build a first badge, step by step, in FOLDER.",
        "materials": "List what to buy for badges, how much of it, and how to cut the lens sheets.",
        "pitch-test": "Make a chart that measures a lens sheet's true pitch.",
        "calibrate": "Make a lens profile from a chart of `moireid pitch-test`, or calibrate a camera.",
    },
    "The registry, and access to the studio": {
        "registry": "Look after the registry of badges: list, show, revoke, audit.",
        "token": "Make, list and revoke access tokens for the studio.",
    },
    "For researchers: many films at once, and the figures that this project states": {
        "lab": "Print this project's figures, and score many films.",
    },
}
#: The commands of this package: each module is imported when its command is called, or its help is shown.
OWN = {
    "print": "moireid.cli.printing.print_cmd:print_command",
    "enroll": "moireid.cli.enroll_cmd:enroll_command",
    "verify": "moireid.cli.verify.verify_cmd:verify_command",
    "identify": "moireid.cli.verify.identify_cmd:identify_command",
    "attest": "moireid.cli.attest.attest_cmd:attest_group",
    "simulate": "moireid.cli.simulate_cmd:simulate_command",
    "materials": "moireid.cli.printing.materials_cmd:materials_command",
    "first-badge": "moireid.cli.first_badge_cmd:first_badge_command",
    "pitch-test": "moireid.cli.pitch_cmd:pitch_test_command",
    "calibrate": "moireid.cli.pitch_cmd:calibrate_command",
    "registry": "moireid.cli.registry:registry_group",
}
#: Commands that another distribution of the project adds, by its entry points, and which that is.
ELSEWHERE = {
    **dict.fromkeys(("serve", "token", "watch"), "moireid-studio"),
    "lab": "moireid-lab",
}
#: Of every command: what asks for its help, which shows what is taken where an option is left out.
SETTINGS: dict[str, Any] = {"help_option_names": ["-h", "--help"], "show_default": True}
#: Commands of the lab that are also called without its name; the help does not list them.
OF_LAB = ("bench", "evaluate")


class Sections(click.Group):
    """A group with the commands of this package and of those that add some; its help lists them by SECTIONS."""

    def list_commands(self, context: click.Context) -> list[str]:
        """Names of the commands that are installed, in the order of SECTIONS."""
        return [name for names in SECTIONS.values() for name in names if name in OWN or _is_installed(ELSEWHERE[name])]

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        """Find a command by its name.

        Raises: ClickException where its distribution is not installed; Removed if the command is gone.
        """
        if name in OF_LAB and isinstance(lab := self.get_command(context, "lab"), click.Group):
            return lab.get_command(context, name)
        if name in OWN:
            # Without a search for entry points, whose import alone takes longer than most commands' help.
            own: click.Command = pkgutil.resolve_name(OWN[name])
            return own
        if name in ELSEWHERE:
            if not _is_installed(needed := ELSEWHERE[name]):
                raise click.ClickException(
                    f"'moireid {name}' needs {needed}, which is not installed; "
                    f"install it with: {install_command(distribution=needed)}"
                )
            from importlib.metadata import entry_points

            found: click.Command = entry_points(group="moireid.commands")[name].load()
            return found
        if name in REMOVED:
            raise Removed(name)
        return None

    def invoke(self, context: click.Context) -> object:
        """Run a command.  Raises: Removed if it is given an option that is gone."""
        try:
            return super().invoke(context)
        except click.UsageError as error:
            check_present(error)
            raise

    def resolve_command(
        self, context: click.Context, words: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that is typed.  Raises: UsageError, with the nearest one, where there is none."""
        try:
            return super().resolve_command(context, words)
        except click.UsageError as error:
            from moireid.user_settings import nearest

            near = nearest(words[0], [*OWN, *ELSEWHERE, *OF_LAB])
            raise click.UsageError(f"no command is called {words[0][:40]!r}{near}.", context) from error

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one table for each section, and what to install for commands that are not there."""
        there = self.list_commands(context)
        for heading, sentences in SECTIONS.items():
            rows = [(name, sentence) for name, sentence in sentences.items() if name in there]
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows, col_spacing=2)
        for distribution in dict.fromkeys(ELSEWHERE.values()):
            missing = [name for name, of in ELSEWHERE.items() if of == distribution and name not in there]
            if missing:
                with formatter.section(f"In {distribution}, which is not installed"):
                    formatter.write_text(", ".join(missing))


def _is_installed(distribution: str) -> bool:
    return find_spec(distribution.replace("-", "_")) is not None


@click.group(cls=Sections, context_settings=SETTINGS)
@click.version_option(__version__, prog_name="moireid")
def moireid() -> None:
    """Print a moiré badge, and check on film that it is real and whose it is.

    A badge is a lenticular sheet (a sheet of narrow lenses) over printed lines. Where the two meet, dark bands appear:
    moiré fringes. When the badge or the camera moves, the fringes move by an exact law of optics, which is hard to fake
    in a film. The spacing of the lines says whose badge it is.

    \b
    Start here:  print-your-badge "Ada Lovelace" --out ada   (or: moireid print)
                 moireid enroll ada/badge.json
                 moireid verify film.mp4 --claim "Ada Lovelace"
    """


def main() -> None:
    """Run `moireid`."""
    _run(moireid, "moireid")


def print_your_badge() -> None:
    """Run `print-your-badge`, which is `moireid print`."""
    from moireid.cli.printing.print_cmd import print_command

    _run(print_command, "print-your-badge")


def _run(command: click.Command, name: str) -> None:
    """Run a command; wrong usage gives one sentence, an interrupt is quiet, and a closed stream is not an error."""
    # Else a fifth of a short command's time goes into looking for garbage among what its packages load.
    gc.set_threshold(50_000)
    open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A letter that the terminal cannot show becomes an escape, not an error after the work is done.
            stream.reconfigure(errors="backslashreplace")
    try:
        code = command.main(prog_name=name, standalone_mode=False, **SETTINGS) or 0
        sys.stdout.flush()
        sys.exit(code)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        _leave("", BAD_INPUT)
    except click.UsageError as error:
        at = f"{error.ctx.command_path} --help" if error.ctx else f"{name} --help"
        _leave(f"error: {error.format_message()} See '{at}'.", BAD_INPUT)
    except click.ClickException as error:
        _leave(f"error: {error.format_message()}", BAD_INPUT)
    except (click.Abort, KeyboardInterrupt):
        _leave("interrupted; nothing half-written is left", 130)
    except BrokenPipeError:
        _leave("", 141)
    except OSError as error:
        _leave(f"error: the output cannot be written ({error.strerror})", BAD_INPUT)


def _leave(message: str, code: int) -> NoReturn:
    """Say why on stderr, and leave without another try at a stdout that may be gone."""
    if message:
        from moireid.cli.common import say

        say(" ".join(message.split("\n")))
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - Python flushes it at exit.
    sys.exit(code)
