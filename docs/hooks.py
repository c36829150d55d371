"""What mkdocs asks as it builds: the page of commands, made from the programs' own help so that it is never stale."""

from __future__ import annotations

from collections.abc import Iterator

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from moireid.cli.main import moireid

WIDTH = 84
INTRO = """# Commands

Made from the programs' own `--help` when this site was built. `print-your-badge` is `moireid print`.
Every command that tells something takes `--json`: one JSON object on stdout, and nothing else there.

| exit code | meaning |
|---|---|
| 0 | done; accepted; found |
| 1 | rejected; found to be nobody's |
| 2 | wrong usage or bad input; one sentence on stderr says what, and what to do |
| 3 | inconclusive |
"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the page of commands."""
    files.append(File.generated(config, "commands.md", content=INTRO + "".join(_sections(moireid, "moireid", None))))
    return files


def _sections(command: click.Command, name: str, parent: click.Context | None) -> Iterator[str]:
    """One section a command, its own commands after it."""
    widths = {"terminal_width": WIDTH, "max_content_width": WIDTH}
    context = click.Context(command, parent=parent, info_name=name, **(command.context_settings | widths))
    yield f"\n## {context.command_path}\n\n```{{ .text .help }}\n{command.get_help(context)}\n```\n"
    if isinstance(command, click.Group):
        for each in command.list_commands(context):
            found = command.get_command(context, each)
            if found is not None and not found.hidden:
                yield from _sections(found, each, context)
