"""print-your-badge: from a name to the files that a person prints."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    FiniteRange,
    FolderPath,
    friendly,
    interrupts,
    json_option,
    overwrite_option,
    say,
    show_json,
    tell_mount,
)
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.designer import Request
    from moireid.fabrication.process import MountFigures
    from moireid.registry import Registry


@click.command("print")
@click.argument("name", required=False)
@click.option(
    "--people",
    "people_csv",
    type=click.Path(path_type=Path),
    help="Instead of NAME: a CSV file with the columns name and, if wished, payload; fills sheets for an event.",
)
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the files.")
@click.option(
    "--registry", "registry_url", metavar="URL", help="Also issue the badge in this registry (SQLAlchemy URL)."
)
@click.option("--payload", metavar="HEX", help="The identity, 16 or 32 hex digits; else it is derived from the name.")
@click.option(
    "--key",
    "key_file",
    type=click.Path(path_type=Path),
    help="Make the fingerprint of this public key (PEM) the identity.",
)
@click.option(
    "--code", type=click.Choice(["spacing", "pitch"]), default="spacing", show_default=True, help="Code family."
)
@click.option(
    "--lens",
    default="50lpi",
    show_default=True,
    metavar="LABEL|FILE",
    help="Lenticular sheet: 40lpi, 50lpi, 60lpi, 75lpi, or a lens profile that moireid calibrate wrote (.json).",
)
@click.option(
    "--front",
    type=click.Choice(["lens", "mask"]),
    default="lens",
    show_default=True,
    help="A lenticular sheet, or a line mask of its pitch printed on clear film over an acrylic spacer.",
)
@click.option("--gap", "gap_mm", type=FiniteRange(0, 100), show_default="1.5", help="Spacer of a mask, mm thick.")
@click.option("--printer-dpi", type=click.IntRange(72, 9600), default=1200, show_default=True, help="Dots per inch.")
@click.option("--paper", type=click.Choice(["a4", "letter"]), default="a4", show_default=True)
@click.option(
    "--range", "range_text", default="0.8-2.5", show_default=True, metavar="M-M", help="Camera distances, metres."
)
@click.option(
    "--axes", type=click.Choice(["x", "xy"]), default="x", show_default=True, help="Directions that the fringes sense."
)
@click.option("--size", "size_text", default="146x160", show_default=True, metavar="WxH", help="Board, mm.")
@click.option(
    "--form",
    type=click.Choice(["dots", "vector", "bitmap"]),
    default="dots",
    show_default=True,
    help="Lines on the printer's dots, as plain vectors, or as a picture of one bit a dot.",
)
@click.option(
    "--measured-scale",
    "scale_text",
    metavar="X[,Y]",
    help="What the scale bars of an earlier print measured over what they say, such as 0.9973; prints true to size.",
)
@click.option(
    "--mount",
    type=click.Choice(["lanyard", "clip", "stand", "none"]),
    show_default="lanyard; with --people none",
    help="What carries the badge; with it come the parts to 3D-print and an acrylic stack to laser-cut.",
)
@click.option(
    "--kerf",
    "kerf_mm",
    type=FiniteRange(0, 1),
    show_default="0.15",
    metavar="MM",
    help="Width that the laser burns away; 0 where the shop compensates.",
)
@click.option(
    "--acrylic",
    "base_mm",
    type=FiniteRange(2, 10),
    show_default="3",
    metavar="MM",
    help="Thickness of the acrylic base plate; frame and cover follow from the badge.",
)
@click.option(
    "--mount-figure",
    "mount_pairs",
    multiple=True,
    metavar="NAME=MM",
    help="Another figure of the mount, by the name that messages give it, such as card_mm=0.5; may be repeated.",
)
@click.option("--explain", is_flag=True, help="Show why the badge is as it is.")
@overwrite_option
@json_option
@friendly
def print_command(
    name: str | None,
    people_csv: Path | None,
    folder: Path,
    registry_url: str | None,
    payload: str | None,
    key_file: Path | None,
    code: str,
    lens: str,
    front: str,
    gap_mm: float | None,
    printer_dpi: int,
    paper: str,
    range_text: str,
    axes: str,
    size_text: str,
    form: str,
    scale_text: str | None,
    mount: str | None,
    kerf_mm: float | None,
    base_mm: float | None,
    mount_pairs: tuple[str, ...],
    explain: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Make the badge of NAME: PDF to print at 100 %, preview, assembly sheet, and a mount.

    With --people, the badges of many: sheets with as many boards as fit, a folder for each person, and a summary; with
    --mount too, one set of a mount's files for all.

    The identity is derived from the name, so the same name gives the same badge; with --registry an identity that
    somebody else holds is never given twice.
    """
    from moireid.designer import Request, payload_from_hex, payload_from_key
    from moireid.designer.request import clean_name, parse_range_m, parse_scale, parse_size_mm
    from moireid.fabrication.package import file_names
    from moireid.fabrication.parts import plan_parts
    from moireid.fabrication.process import mount_figures
    from moireid.files import planned

    if (name is None) == (people_csv is None):
        raise SpecError("give the NAME of one person, or --people with a CSV file of many")
    if payload is not None and key_file is not None:
        raise SpecError("give --payload or --key, not both")
    if gap_mm is not None and front != "mask":
        raise SpecError("--gap is the spacer of a mask; give --front mask with it, or leave it out")
    kind = mount or ("lanyard" if people_csv is None else "none")
    given = {"kerf_mm": kerf_mm, "base_mm": base_mm}
    pairs = [*mount_pairs, *(f"{key}={value}" for key, value in given.items() if value is not None)]
    if pairs and kind == "none":
        raise SpecError(
            "--kerf, --acrylic and --mount-figure are figures of a mount; give --mount lanyard, clip or stand with "
            "them, or leave them out"
        )
    request = Request(
        clean_name("Everybody" if name is None else name),
        lens,
        printer_dpi,
        paper,
        parse_range_m(range_text),
        parse_size_mm(size_text),
        code,
        axes,
        form,
        front,
        Request.gap_mm if gap_mm is None else gap_mm,
    )
    measured_scale = parse_scale(scale_text) if scale_text else (1.0, 1.0)
    figures = mount_figures(pairs)
    if people_csv is not None:
        if payload is not None or key_file is not None:
            raise SpecError("--payload and --key are for one person; give the payloads in a column of the CSV file")
        from moireid.cli.people import print_people

        print_people(
            people_csv,
            request,
            folder,
            registry_url,
            measured_scale,
            mount=kind,
            figures=figures,
            overwrite=overwrite,
            as_json=as_json,
        )
        return
    chosen = None
    if payload is not None:
        chosen = payload_from_hex(payload, family=code)
    elif key_file is not None:
        chosen = payload_from_key(key_file)
    # A wish that cannot be is refused before a registry is made for it.
    parts = plan_parts(_design(request, chosen, None), kind, figures)
    order = _Order(request, chosen, folder, kind, measured_scale, figures, explain, overwrite, as_json)
    if registry_url is None:
        _print_one(order, None)
        return
    planned([folder / name for name in file_names(parts)], overwrite=overwrite, make_folders=False)
    from moireid.registry import open_registry

    with open_registry(registry_url, create=True) as registry:
        _print_one(order, registry)


@dataclass(frozen=True)
class _Order:
    """What one person's badge is to be, and how to tell of it; measured_scale: x and y."""

    request: Request
    payload: bytes | None
    folder: Path
    mount: str
    measured_scale: tuple[float, float]
    figures: MountFigures
    explain: bool
    overwrite: bool
    as_json: bool


def _print_one(order: _Order, registry: Registry | None) -> None:
    """Design, make and issue one badge, and tell of it."""
    from moireid.designer import explain as explain_badge
    from moireid.fabrication.package import print_badge
    from moireid.fabrication.page.lettering import missing_note

    badge = _design(order.request, order.payload, registry)
    if note := missing_note([badge]):
        say(f"note: {note}")
    issue = (lambda: registry.enroll(badge)) if registry else None
    with interrupts() as check:

        def tell(file: str) -> None:
            check()
            say(f"making {file}")

        printed = print_badge(
            badge,
            order.folder,
            mount=order.mount,
            measured_scale=order.measured_scale,
            figures=order.figures,
            overwrite=order.overwrite,
            before_moving=issue,
            progress=tell,
        )
    files = {name: str(path) for name, path in printed.files.items()}
    tell_mount(printed.left_out, printed.removed)
    rows = explain_badge(badge)
    if order.as_json:
        show_json(
            {
                "id": badge.id,
                "name": badge.name,
                "files": files,
                "issued": registry is not None,
                "mount_mass_g": printed.mount_mass_g,
                "mount_figures": printed.mount_figures,
                "left_out": printed.left_out,
                "removed": [str(path) for path in printed.removed],
                "measured_scale": order.measured_scale,
                "explain": dict(rows),
            }
        )
        return
    click.echo(f"Badge {badge.id} for {badge.name}:")
    for path in files.values():
        click.echo(f"  {path}")
    if order.explain:
        click.echo()
        for what, figure in rows:
            click.echo(f"  {what:<26} {figure}")
    click.echo("Print badge.pdf at 100 % and follow assembly.pdf.")


def _design(request: Request, payload: bytes | None, registry: Registry | None) -> Badge:
    """The badge for the request; with a registry, one whose id nobody else holds."""
    from moireid.designer.free import free_badge

    badge, holder = free_badge(request, payload, registry.by_id if registry else lambda _: None)
    if holder is not None and payload is None:
        say(
            f"note: this very badge was issued to {holder.name} on {holder.issued_at[:10]}; for another person of "
            "that name give --payload"
        )
    return badge
