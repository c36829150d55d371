"""enroll and registry: who was issued which badge."""

from __future__ import annotations

from pathlib import Path

import click

from moireid.cli.common import friendly, json_option, registry_option, show_json


@click.command("enroll")
@click.argument("badge_json", type=click.Path(path_type=Path))
@registry_option
@json_option
@friendly
def enroll_command(badge_json: Path, registry_url: str | None, as_json: bool) -> None:
    """Enter the badge in BADGE_JSON into the registry; doing it again changes nothing."""
    from moireid.badge import load_badge
    from moireid.errors import SpecError
    from moireid.idcodes import spells_its_id
    from moireid.registry import open_registry

    badge = load_badge(badge_json)
    if badge.id is None or not any(grating.code for grating in badge.gratings):
        raise SpecError(f"{badge_json} is a board without an identity; print a badge with print-your-badge")
    if not spells_its_id(badge):
        raise SpecError(
            f"{badge_json}: its lines do not spell its id {badge.id}, so no film could bear it out; print it anew"
        )
    with open_registry(registry_url, create=True) as registry:
        record = registry.enroll(badge)
        if as_json:
            show_json(
                {"id": record.id, "name": record.name, "issued_at": record.issued_at, "registry": registry.shown_url}
            )
        else:
            click.echo(f"{record.name} holds badge {record.id} since {record.issued_at} in {registry.shown_url}")


@click.group("registry")
def registry_group() -> None:
    """Look at the registry of issued badges."""


@registry_group.command("init")
@registry_option
@json_option
@friendly
def registry_init(registry_url: str | None, as_json: bool) -> None:
    """Make an empty registry; an existing one is left as it is."""
    from moireid.registry import open_registry

    with open_registry(registry_url, create=True) as registry:
        count = registry.count()
        if as_json:
            show_json({"registry": registry.shown_url, "badges": count})
        else:
            click.echo(f"{registry.shown_url} is ready and holds {count} badges")


@registry_group.command("list")
@registry_option
@json_option
@friendly
def registry_list(registry_url: str | None, as_json: bool) -> None:
    """List everybody who holds a badge, by name."""
    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        if as_json:
            rows = [{"id": r.id, "name": r.name, "issued_at": r.issued_at} for r in registry.records()]
            show_json({"registry": registry.shown_url, "badges": rows})
            return
        for record in registry.records():
            click.echo(f"{record.id}  {record.issued_at}  {record.name}")


@registry_group.command("show")
@click.argument("claim", metavar="NAME|ID")
@registry_option
@json_option
@friendly
def registry_show(claim: str, registry_url: str | None, as_json: bool) -> None:
    """Show the record of one person, by name or id."""
    import json

    from moireid.registry import open_registry

    with open_registry(registry_url, create=False) as registry:
        record = registry.find(claim)
    if as_json:
        badge = json.loads(record.badge.to_json())
        show_json({"id": record.id, "name": record.name, "issued_at": record.issued_at, "badge": badge})
    else:
        click.echo(f"{record.name} holds badge {record.id} since {record.issued_at}")
