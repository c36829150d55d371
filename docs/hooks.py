"""What mkdocs asks as it builds: the reference pages that are made from the code, so that they are never stale.

commands.md     every command, from click's own help
simulation.md   builds, flaws and effects, from the tables of `simulate`
python/         a page of each room, from the docstrings of what it exports
badge-json.md   each field of badge.json, from the shipped schema; report-json.md the same of a report
threats.md      the text of THREATS.md
"""

from __future__ import annotations

import importlib
import inspect
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import moireid
from moireid.cli.main import moireid as program
from moireid.simulate.effects.table import KINDS, STRENGTHS
from moireid.simulate.flaw_table import FLAWS, PRESETS

HOUSE = Path(moireid.__file__).parent
WIDTH = 84
COMMANDS = """# Commands

This page is made from the programs' own `--help`. `print-your-badge` is the same as `moireid print`.

Commands that report something take `--json`. They then print one JSON object on stdout, and nothing else there.
What an exit code means is on [its own page](exit-codes.md).
"""
FIELDS = """# {title}

{text}

This page is made from the JSON Schema that moireid ships and checks every file against ({where}).
A field in **bold** must be there. `[]` means each entry of a list.
"""
TABLE = "\n| field | type | meaning |\n|---|---|---|\n"
BADGE_TEXT = """The file that says all that is printed on one badge. Anyone with it can print the badge, so keep it as
you would keep a key. Lengths are in millimetres of the page: origin top left, x to the right, y down."""
REPORT_TEXT = """What `moireid verify --json` prints, and what `--report` writes as `report.json`. Within a format, keys
are only added. So a program must pass over the keys that it does not know. A figure is null where nothing was
measured."""
ROOMS = (
    *("moireid", "moireid.designer", "moireid.fabrication", "moireid.simulate", "moireid.verifier", "moireid.registry"),
    *("moireid.calibration", "moireid.attest", "moireid.idcodes", "moireid.errors", "moireid_studio.challenge"),
)
#: Of these rooms each name is imported from its file.
BY_FILE = {
    "moireid.fabrication": (
        *("package.PrintResult", "package.print_badge", "event.print_event", "page.pdf.write_badge_pdf"),
        "solid_parts.mount_solids",
    ),
    "moireid.attest": (
        *("checking.CheckResult", "checking.check", "envelope.signed_envelope", "registry_answer.held_against"),
        *("signing_keys.SigningKey", "signing_keys.load_public_key", "signing_keys.load_signing_key"),
    ),
    "moireid.calibration": (
        *("chart_reading.ChartView", "chart_reading.view_chart", "lens_fit.lens_from_views", "still.load_pictures"),
    ),
}
SIMULATION = """# What is simulated

This page is made from the tables of `moireid simulate`. What the verifier makes of each effect is in
[accuracy](../accuracy.md#what-the-world-does-to-a-film).
"""
#: The function; `moireid.simulate` is a package as well.
SIMULATE = "moireid.simulate.film_badge.simulate"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made."""
    made = {
        "commands": COMMANDS + "".join(_sections(program, "moireid", None)),
        "badge-json": _fields("badge", "badge.json", BADGE_TEXT, "`src/moireid/schema/badge.schema.json`"),
        "report-json": _fields("report", "The report", REPORT_TEXT, "in the package as `schema/report.schema.json`"),
        "simulation": "".join(_simulation()),
    } | {f"python/{module.rpartition('.')[2]}": "".join(_room(module)) for module in ROOMS}
    for name, text in made.items():
        files.append(File.generated(config, f"reference/{name}.md", content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Put the text of THREATS.md in its place."""
    if page.file.src_uri != "explanation/threats.md":
        return markdown
    return (Path(config.docs_dir).parent / "THREATS.md").read_text(encoding="utf-8").replace("](docs/", "](../")


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


def _room(module: str) -> Iterator[str]:
    """The page of a room: what it is for, and each name that it offers, by its docstring; errors have a page of their
    own.
    """
    room = importlib.import_module(module)
    purpose, _, _ = inspect.cleandoc(room.__doc__ or "").partition("\n\n")
    yield f"# {module}\n\n{purpose}\n"
    for name in BY_FILE.get(module) or room.__all__:
        where = SIMULATE if (module, name) == ("moireid", "simulate") else f"{module}.{name}"
        if module != "moireid" or not (name.endswith("Error") or name.startswith("__")):
            yield f"\n::: {where}\n    options:\n      heading_level: 2\n"


def _simulation() -> Iterator[str]:
    """The page of builds, flaws and effects."""
    yield f"{SIMULATION}\n## Builds\n\n| `--build` | its flaws |\n|---|---|\n| `ideal` | as designed |\n"
    for name, flaws in PRESETS.items():
        listed = ", ".join(f"`{flaw}={value:g}`" for flaw, value in flaws.items())
        yield f"| `{name}` | {listed or 'only place, turn and scales are off'} |\n"
    yield "\n## Flaws\n\n| `--flaw` | unit | range | meaning |\n|---|---|---|---|\n"
    for name, flaw in FLAWS.items():
        yield f"| `{name}` | {flaw.unit} | {flaw.low:g} to {flaw.high:g} | {flaw.meaning} |\n"
    yield f"\n## Effects\n\n| `--effect` | {', '.join(STRENGTHS)} | figure | source |\n|---|---|---|---|\n"
    for name, kind in KINDS.items():
        yield f"| `{name}` | {', '.join(f'{one:g}' for one in kind.figures)} | {kind.what} | {kind.source} |\n"


def _fields(schema: str, title: str, text: str, where: str) -> str:
    """A page of a shipped schema: a table of its fields, and one for each object within."""
    document = json.loads((HOUSE / "schema" / f"{schema}.schema.json").read_text(encoding="utf-8"))
    return FIELDS.format(title=title, text=text, where=where) + "".join(_tables(document, document, ""))


def _tables(node: dict[str, Any], root: dict[str, Any], path: str) -> Iterator[str]:
    """The table of an object of a schema, and those of the objects in it."""
    if path:
        yield f"\n## {path} {{ #{_anchor(path)} }}\n"
    yield TABLE
    within: list[tuple[dict[str, Any], str]] = []
    for name, given in node["properties"].items():
        field = _resolved(given, root)
        item = _resolved(field.get("items", {}), root)
        meaning = field.get("description", "").replace("|", "\\|")
        for inner, mark in ((field, ""), (item, "[]")):
            if "properties" in inner:
                below = f"{path}.{name}{mark}".lstrip(".")
                meaning += f" ([its fields](#{_anchor(below)}))"
                within.append((inner, below))
        shown = f"**`{name}`**" if name in node.get("required", []) else f"`{name}`"
        yield f"| {shown} | {_kind(field, root)} | {meaning.strip()} |\n"
    for inner, below in within:
        yield from _tables(inner, root, below)


def _anchor(path: str) -> str:
    return path.replace("[]", "").replace(".", "-")


def _resolved(node: dict[str, Any], root: dict[str, Any]) -> dict[str, Any]:
    """A node, with what it refers to."""
    if "$ref" not in node:
        return node
    return root["$defs"][node["$ref"].rsplit("/", 1)[1]] | {key: value for key, value in node.items() if key != "$ref"}


def _kind(field: dict[str, Any], root: dict[str, Any]) -> str:
    """Type and range of a field in a few words."""
    if "const" in field:
        return f"always {field['const']}"
    if "enum" in field:
        shown = [f"`{each}`" for each in field["enum"]]
        return " or ".join(shown) if len(shown) <= 4 else f"one of {len(shown)}: {', '.join(shown[:2])}, …"
    if "anyOf" in field:
        return " or ".join(_kind(each, root) for each in field["anyOf"])
    types = field.get("type", "any")
    words = [" or ".join(types) if isinstance(types, list) else types]
    if "array" in words[0] and "items" in field:
        inner = _resolved(field["items"], root)
        words = [f"list of {inner.get('type', 'object')}s" if isinstance(inner.get("type"), str) else "list"]
        if field.get("minItems") == field.get("maxItems") and "minItems" in field:
            words = [f"{field['minItems']} {words[0].removeprefix('list of ')}"]
    least, above = field.get("minimum"), field.get("exclusiveMinimum")
    most, below = field.get("maximum"), field.get("exclusiveMaximum")
    words += [f"≥ {least:g}"] if least is not None else [f"> {above:g}"] if above is not None else []
    words += [f"≤ {most:g}"] if most is not None else [f"< {below:g}"] if below is not None else []
    return ", ".join(words)
