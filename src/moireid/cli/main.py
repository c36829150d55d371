"""The programs `moireid` and `print-your-badge`."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import NoReturn

import click

from moireid import __version__
from moireid.cli.attest.attest_cmd import attest_group
from moireid.cli.bench_cmd import bench_command
from moireid.cli.common import BAD_INPUT
from moireid.cli.enroll_cmd import enroll_command
from moireid.cli.evaluate_cmd import evaluate_command
from moireid.cli.film_set_cmd import film_set_command
from moireid.cli.generator_cmd import generator_group
from moireid.cli.pitch_cmd import calibrate_command, pitch_test_command
from moireid.cli.printing.print_cmd import print_command
from moireid.cli.registry import registry_group
from moireid.cli.serve_cmd import serve_command, token_group
from moireid.cli.simulate_cmd import simulate_command
from moireid.cli.verdicts_cmd import verdicts_command
from moireid.cli.verify.identify_cmd import identify_command
from moireid.cli.verify.verify_cmd import verify_command
from moireid.cli.watch.watch_cmd import watch_command

#: The sections of `moireid --help`, and the commands of each in the order in which people need them.
SECTIONS: dict[str, tuple[click.Command, ...]] = {
    "Commands that most people need": (
        print_command,
        enroll_command,
        verify_command,
        identify_command,
        watch_command,
        attest_group,
        simulate_command,
        serve_command,
    ),
    "Lens sheets": (pitch_test_command, calibrate_command),
    "The registry, and access to the studio": (registry_group, token_group, verdicts_command),
    "Many films at once": (film_set_command, generator_group, evaluate_command),
    "The figures that this project states": (bench_command,),
}


class Sections(click.Group):
    """A group whose help lists its commands under the headings of SECTIONS."""

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write one table for each section."""
        for heading, commands in SECTIONS.items():
            with formatter.section(heading):
                rows = [(command.name or "", command.get_short_help_str(limit=80)) for command in commands]
                formatter.write_dl(rows, col_spacing=2)


@click.group(cls=Sections, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="moireid")
def moireid() -> None:
    """Print a moiré badge, and check on film that it is real and whose it is.

    A badge is a lenticular sheet (a sheet of narrow lenses) over printed lines. Where the two meet, dark bands appear:
    moiré fringes. When the badge or the camera moves, the fringes move by an exact law of optics, which is hard to fake
    in a film. The spacing of the lines says whose badge it is.

    \b
    Start here:  moireid print "Ada Lovelace" --out ada
                 moireid enroll ada/badge.json
                 moireid verify film.mp4 --claim "Ada Lovelace"
    """


for _commands in SECTIONS.values():
    for _command in _commands:
        moireid.add_command(_command)


def main() -> None:
    """Run `moireid`."""
    _run(moireid, "moireid")


def print_your_badge() -> None:
    """Run `print-your-badge`, which is `moireid print`."""
    _run(print_command, "print-your-badge")


def _run(command: click.Command, name: str) -> None:
    """Run a command; wrong usage gives one sentence, an interrupt is quiet, and a closed stdout is not an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A letter that the terminal cannot show becomes an escape, not an error after the work is done.
            stream.reconfigure(errors="backslashreplace")
    try:
        code = command.main(prog_name=name, standalone_mode=False) or 0
        sys.stdout.flush()
        sys.exit(code)
    except click.exceptions.NoArgsIsHelpError as error:
        _leave(error.format_message(), BAD_INPUT)
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
        click.echo(" ".join(message.split("\n")) if message.startswith("error") else message, err=True)
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.flush()
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - Python flushes it at exit.
    sys.exit(code)
