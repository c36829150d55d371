"""The programs `moireid` and `print-your-badge`."""

from __future__ import annotations

import sys

import click

from moireid import __version__
from moireid.cli.bench_cmd import bench_command
from moireid.cli.common import BAD_INPUT
from moireid.cli.enroll_cmd import enroll_command, registry_group
from moireid.cli.print_cmd import print_command
from moireid.cli.simulate_cmd import simulate_command
from moireid.cli.verify_cmd import identify_command, verify_command


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="moireid")
def moireid() -> None:
    """Print a moiré badge, film it, and check its motion and whose badge it is.

    A badge is a lenticular sheet over printed lines. As badge or camera moves, its fringes shift by an exact optical
    law, which a real camera records for free; and the spacing of the lines says whose badge it is.

    \b
    Begin with:  moireid print "Ada Lovelace" --out ada
                 moireid enroll ada/badge.json
                 moireid verify film.mp4 --claim "Ada Lovelace"
    """


for command in (
    print_command,
    enroll_command,
    verify_command,
    identify_command,
    simulate_command,
    registry_group,
    bench_command,
):
    moireid.add_command(command)


def main() -> None:
    """Run `moireid`."""
    _run(moireid, "moireid")


def print_your_badge() -> None:
    """Run `print-your-badge`, which is `moireid print`."""
    _run(print_command, "print-your-badge")


def _run(command: click.Command, name: str) -> None:
    """Run a command; wrong usage is one sentence, and an interrupt is quiet."""
    try:
        sys.exit(command.main(prog_name=name, standalone_mode=False) or 0)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        sys.exit(BAD_INPUT)
    except click.UsageError as error:
        at = f"{error.ctx.command_path} --help" if error.ctx else f"{name} --help"
        click.echo(f"error: {error.format_message()} See '{at}'.", err=True)
        sys.exit(BAD_INPUT)
    except click.ClickException as error:
        click.echo(f"error: {error.format_message()}", err=True)
        sys.exit(BAD_INPUT)
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted; nothing half-written is left", err=True)
        sys.exit(130)
