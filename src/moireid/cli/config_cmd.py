"""config: what a user sets once for all commands."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from moireid.cli.common import PAPER, PRINTER_DPI, echo, friendly, json_option, say, show_json
from moireid.errors import SpecError

#: What the options of these names take.
TYPES: dict[str, Any] = {"paper": PAPER, "printer-dpi": PRINTER_DPI, "public-url": click.STRING}


@click.group("config")
def config_group() -> None:
    """Show and change what you set once for all commands.

    An option of a command comes first, then MOIREID_REGISTRY (for the registry alone), then what is set here, then the
    default. The settings are in a file config.toml in the folder of your user settings, or in the one that
    MOIREID_CONFIG names.

    \b
    registry     a path of an SQLite file, or an SQLAlchemy URL. A badge is
                 entered while it is printed only with print --registry
    actor        who does something, as the registry's log is to name them
    lens         the lens sheet of print and pitch-test: a label, or a profile
    paper        a4 or letter
    printer-dpi  the printer's dots per inch
    public-url   the address by which other people reach your studio (serve)
    """


@config_group.command("show")
@json_option
@friendly
def config_show(as_json: bool) -> None:
    """Show each setting, and where it is from.

    That is the environment, the file, or neither, where the command's own default counts.
    """
    from moireid.user_settings import KEYS, REGISTRY_VARIABLE, load_settings, settings_file

    found = load_settings()
    rows = [(key, found.get(key), "file" if key in found else "default") for key in KEYS]
    if chosen := os.environ.get(REGISTRY_VARIABLE):
        rows = [(key, chosen, "environment") if key == "registry" else (key, value, of) for key, value, of in rows]
    rows = [(key, _shown(key, value), of) for key, value, of in rows]
    if as_json:
        settings = {key: {"value": value, "from": of} for key, value, of in rows}
        show_json({"file": str(settings_file()), "settings": settings})
        return
    echo(f"{settings_file()}{'' if settings_file().exists() else ' (not there: nothing is set)'}")
    for key, value, of in rows:
        echo(f"  {key:<12} {'-' if value is None else value} ({of})")


@config_group.command("set")
@click.argument("key")
@click.argument("value")
@friendly
def config_set(key: str, value: str) -> None:
    """Set KEY to VALUE.

    Such as: moireid config set registry people.sqlite3.
    """
    from moireid.user_settings import check_key, load_settings, save_settings

    check_key(key, "there is")
    path = save_settings(load_settings() | {key: _checked(key, value)})
    say(f"{key} is set in {path}")


@config_group.command("unset")
@click.argument("key")
@friendly
def config_unset(key: str) -> None:
    """Forget what KEY was set to."""
    from moireid.user_settings import check_key, load_settings, save_settings

    check_key(key, "there is")
    found = load_settings()
    if found.pop(key, None) is None:
        say(f"{key} was not set")
        return
    say(f"{key} is set no longer in {save_settings(found)}")


def _checked(key: str, value: str) -> str:
    """The value as it is kept: paths absolute, as the next command may come from elsewhere.

    Raises: MoireIdError where no command would take it.
    """
    if key == "registry":
        from moireid.registry.engine import read_url

        return read_url(value).render_as_string(hide_password=False)
    if key == "actor":
        from moireid.registry.keys import checked_actor

        return checked_actor(value)
    if key == "lens":
        from moireid.profiles import lens_named, load_lens_profile

        if not value.lower().endswith(".json"):
            lens_named(value)
            return value
        load_lens_profile(Path(value))
        return str(Path(value).absolute())
    try:
        return str(TYPES[key].convert(value, None, None))
    except click.BadParameter as error:
        raise SpecError(f"{key}: {error.message}") from error


def _shown(key: str, value: str | None) -> str | None:
    """A setting for people and programs: a registry without its password."""
    if key != "registry" or value is None:
        return value
    from moireid.registry.engine import read_url, show_url

    return show_url(read_url(value))
