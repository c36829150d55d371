"""print-your-badge: from a name to the files that a person prints."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from moireid.cli.common import (
    FiniteRange,
    FolderPath,
    actor_option,
    expires_option,
    form_option,
    friendly,
    json_option,
    overwrite_option,
    paper_option,
    printer_dpi_option,
    say,
    scale_option,
    show_json,
    status_line,
    tell_mount,
)
from moireid.cli.printing.wear import Wear
from moireid.cli.printing.wear_options import wear_options
from moireid.errors import SpecError

if TYPE_CHECKING:
    from moireid.designer import Request
    from moireid.fabrication.process import MountFigures
    from moireid.registry import Registry


@click.command("print")
@click.argument("name", required=False)
@click.option(
    "--people",
    "people_csv",
    type=click.Path(path_type=Path),
    help="Instead of NAME: a list (CSV) with the column name, and line (below the name), payload, logo, portrait and "
    "colour if you like. Makes all badges of an event.",
)
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the files.")
@click.option(
    "--registry", "registry_url", metavar="URL", help="Also enter the badge into this registry, as moireid enroll does."
)
@click.option("--payload", metavar="HEX", help="The identity: 16 or 32 hex digits; default: drawn by chance.")
@click.option(
    "--key",
    "key_file",
    type=click.Path(path_type=Path),
    help="Use the fingerprint of this public key (PEM file) as the identity.",
)
@click.option(
    "--code",
    type=click.Choice(["spacing", "pitch"]),
    default="spacing",
    show_default=True,
    help="How lines carry the identity: by their places, or by their pitch.",
)
@wear_options
@click.option(
    "--lens-thickness",
    "lens_thickness_mm",
    type=FiniteRange(0.05, 20),
    metavar="MM",
    help="How thick the sheet is by a calliper; default: as its label says.",
)
@click.option(
    "--front",
    type=click.Choice(["lens", "array", "mask"]),
    default="lens",
    show_default=True,
    help="What lies on top: a lenticular sheet; an array of round lenses (fly's-eye sheet), which senses both "
    "directions at every point; or a line mask printed on clear film with an acrylic spacer.",
)
@click.option(
    "--gap", "gap_mm", type=FiniteRange(0, 100), show_default="1.5", metavar="MM", help="Thickness of a mask's spacer."
)
@printer_dpi_option
@paper_option
@click.option(
    "--axes",
    type=click.Choice(["x", "xy", "hex"]),
    default="x",
    show_default=True,
    help="Motion that the fringes show: sideways, also up and down, or by three fields at 0, 60 and 120 degrees.",
)
@click.option(
    "--markers",
    type=click.Choice(["squares", "frame"]),
    default="squares",
    show_default=True,
    help="What a film finds the badge by: squares in its corners, or a thin frame around the fringes.",
)
@form_option
@scale_option
@click.option(
    "--mount",
    type=click.Choice(["lanyard", "clip", "stand", "holder", "none"]),
    show_default="lanyard; with --people none",
    help="What holds the badge; it comes as parts to 3D-print and as an acrylic stack to laser-cut. Into a holder a "
    "finished badge is pressed.",
)
@click.option(
    "--kerf",
    "kerf_mm",
    type=FiniteRange(0, 1),
    show_default="0.15",
    metavar="MM",
    help="Width of the laser's cut; 0 if the shop corrects for it.",
)
@click.option(
    "--acrylic",
    "base_mm",
    type=FiniteRange(2, 10),
    show_default="3",
    metavar="MM",
    help="Thickness of the acrylic base plate.",
)
@click.option(
    "--mount-figure",
    "mount_pairs",
    multiple=True,
    metavar="NAME=MM",
    help="Another dimension of the mount, such as card_mm=0.5; may be given several times.",
)
@click.option("--explain", is_flag=True, help="Show the figures of the design.")
@expires_option
@actor_option
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
    lens_thickness_mm: float | None,
    front: str,
    gap_mm: float | None,
    printer_dpi: int,
    paper: str,
    axes: str,
    markers: str,
    form: str,
    scale_text: str | None,
    mount: str | None,
    kerf_mm: float | None,
    base_mm: float | None,
    mount_pairs: tuple[str, ...],
    explain: bool,
    expires: str | None,
    overwrite: bool,
    actor: str | None,
    as_json: bool,
    wear: Wear,
) -> None:
    """Make a badge for NAME, ready to print.

    The folder gets badge.pdf (the page to print at 100 %), preview.png and preview.webp (the badge as worn; the second
    moves), assembly.pdf (how to build it), the files of a mount, and badge.json, which the other commands read.

    The identity is drawn from the system's chance, so the same name printed twice gives two different badges: keep the
    folder, as badge.json is the only copy. It has 128 bits where badge and range carry them; with --registry it has 64,
    which nobody else there holds.

    With --people, badges are made for many people: sheets with as many badges as fit, a folder for each person, and a
    summary. With --mount too, one set of mount files serves them all.

    \b
    Labels for --lens, nominal and as resellers list them; measure yours:
    40lpi 1.25 mm, 50lpi 1.00 mm   the published prototype's shape, at
    60lpi 0.84 mm, 75lpi 0.67 mm   four pitches
    20lpi-2mm     47 degrees       60lpi-1.2mm   26 degrees, for depth
    30lpi-47mil   49 degrees       62lpi-27mil   44 degrees
    40lpi-33mil   49 degrees       75lpi-18mil   49 degrees
    40lpi-2mm     25, for depth    100lpi-14mil  42 degrees
    """
    from moireid.designer import Request, payload_from_hex, payload_from_key
    from moireid.designer.request import clean_name, parse_scale
    from moireid.fabrication.package import file_names
    from moireid.fabrication.page.dress import check_look
    from moireid.fabrication.page.lettering import name_note
    from moireid.fabrication.process import mount_figures
    from moireid.files import planned
    from moireid.looks.content import with_lines

    if (name is None) == (people_csv is None):
        raise SpecError("give either the NAME of one person, or --people with a CSV file of many")
    if payload is not None and key_file is not None:
        raise SpecError("give --payload or --key, not both")
    if lens_thickness_mm is not None and front == "mask":
        raise SpecError("--lens-thickness is of a lens sheet; a mask has a spacer, whose thickness is --gap")
    if gap_mm is not None and front != "mask":
        raise SpecError("--gap is the spacer of a mask; give --front mask with it, or leave it out")
    if expires is not None:
        _check_expiry(expires, registry_url)
    kind = mount or ("lanyard" if people_csv is None else "none")
    given = {"kerf_mm": kerf_mm, "base_mm": base_mm}
    pairs = [*mount_pairs, *(f"{key}={value}" for key, value in given.items() if value is not None)]
    # An adhesive holds page and sheet together where no mount does.
    if kind == "none" and any(not pair.strip().startswith("adhesive_mm") for pair in pairs):
        raise SpecError(
            "--kerf, --acrylic and --mount-figure are figures of a mount; give --mount lanyard, clip, stand or "
            "holder with them, or leave them out (adhesive_mm alone goes without a mount)"
        )
    wish = Request(
        clean_name("Everybody" if name is None else name),
        printer_dpi=printer_dpi,
        paper=paper,
        family=code,
        axes=axes,
        markers=markers,
        form=form,
        front=front,
        gap_mm=Request.gap_mm if gap_mm is None else gap_mm,
        lens_thickness_mm=lens_thickness_mm,
    )
    request = wear.fit(wish)
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
            actor,
            measured_scale,
            mount=kind,
            figures=figures,
            overwrite=overwrite,
            as_json=as_json,
            expires=expires,
            look=wear.look(axes),
            lines=wear.lines,
        )
        return
    chosen = None
    if payload is not None:
        chosen = payload_from_hex(payload, family=code)
    elif key_file is not None:
        chosen = payload_from_key(key_file)
    from moireid.designer.drawn import drawn_badge, nobody

    # A wish that cannot be is refused before a registry is made for it.
    trial = drawn_badge(request, chosen, nobody if registry_url is not None else None)
    name_note(trial.badge.name)
    look = wear.look(axes)
    check_look(with_lines(trial.badge, wear.lines), look)
    kind, parts, note = wear.parts(trial.badge, mount, figures)
    if note:
        say(f"note: {note}")
    order = _Order(request, chosen, folder, kind, measured_scale, figures, explain, overwrite, as_json, expires, wear)
    if registry_url is None:
        _print_one(order, None)
        return
    planned([folder / name for name in file_names(parts, moving=True)], overwrite=overwrite, make_folders=False)
    from moireid.registry import open_registry

    with open_registry(registry_url, create=True, actor=actor) as registry:
        _print_one(order, registry)


def _check_expiry(expires: str, registry_url: str | None) -> None:
    """Raise SpecError where the day is none to come, or no registry is there to hold it."""
    from moireid.registry.face.days import expiry_day

    expiry_day(expires)
    if registry_url is None:
        raise SpecError("--expires is kept by a registry; give --registry with it, or give it to moireid enroll")


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
    expires: str | None
    wear: Wear


def _print_one(order: _Order, registry: Registry | None) -> None:
    """Design, make and issue one badge, and tell of it."""
    from moireid.cli.issue_notes import derived_notes, look_alike_notes
    from moireid.designer import explain as explain_badge
    from moireid.designer.drawn import drawn_badge
    from moireid.fabrication.package import print_badge
    from moireid.fabrication.page.lettering import name_note
    from moireid.looks.content import with_lines

    drawn = drawn_badge(order.request, order.payload, registry.by_id if registry else None)
    badge = with_lines(drawn.badge, order.wear.lines)
    alike = look_alike_notes([badge], registry) if registry else []
    notes = [note for note in (name_note(badge.name), drawn.note, *derived_notes([badge]), *alike) if note]
    for note in notes:
        say(f"note: {note}")
    issue = (lambda: registry.enroll(badge, told=True, expires=order.expires)) if registry else None
    with status_line() as tell:
        printed = print_badge(
            badge,
            order.folder,
            mount=order.mount,
            measured_scale=order.measured_scale,
            figures=order.figures,
            look=order.wear.look(order.request.axes),
            overwrite=order.overwrite,
            before_moving=issue,
            progress=lambda file: tell(f"making {file}"),
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
                "notes": notes,
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
