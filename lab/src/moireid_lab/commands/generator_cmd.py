"""generator-kit: what a user of a video generator needs to forge films of a badge, and to count the results."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click

from moireid.cli.common import FolderPath, echo, friendly, json_option, overwrite_option, registry_option, show_json

#: The names of `evaluation.generator_kit.FORMATS`, written again because importing that room costs a second.
FORMATS = ("848x480", "1280x720", "1920x1080")


@click.group("generator-kit")
def generator_group() -> None:
    """Help to forge films with a video generator."""


@generator_group.command("cut")
@click.argument("manifest_csv", metavar="MANIFEST")
@click.option("--out", "folder", required=True, type=FolderPath(), help="Folder for the kit.")
@click.option(
    "--format",
    "formats",
    type=click.Choice(FORMATS),
    multiple=True,
    help="Size of the frames; may be given several times; default: all.",
)
@registry_option
@click.option(
    "--badge", "badge_json", type=click.Path(path_type=Path), help="The badge.json for films without a claim."
)
@overwrite_option
@json_option
@friendly
def cut_command(
    manifest_csv: str,
    folder: Path,
    formats: tuple[str, ...],
    registry_url: str | None,
    badge_json: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Cut the first frames out of genuine films, and write the prompts.

    MANIFEST is a list as `moireid lab evaluate` reads it; its genuine films are taken. The kit has

    \b
    frames/      the first frame of each film at each size
    prompts.csv  prompts: the camera moves, the badge moves, both move
    clips.csv    the clips to be made, a line each, to be filled in
    clips/       where the clips are put
    films.csv    the list for `moireid lab evaluate`

    Generators make 24 frames a second at 848x480 and 1280x720, and 25 at 1920x1080; clips.csv says so too.
    """
    from moireid.badge import load_badge
    from moireid_lab.evaluation.generator_kit import cut
    from moireid_lab.evaluation.manifest import read_manifest

    badge = load_badge(badge_json) if badge_json else None
    manifest = read_manifest(manifest_csv, registry_url=registry_url, badge=badge)
    files = cut(manifest, manifest_csv, folder, formats=formats or FORMATS, overwrite=overwrite)
    if as_json:
        show_json({"files": [str(path) for path in files]})
    else:
        echo(f"{len(files) - 3} frames in {folder / 'frames'}; make clips of them, and fill in {files[-2]}")


@generator_group.command("list")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@json_option
@friendly
def list_command(folder: Path, as_json: bool) -> None:
    """Count the clips that were kept, and write the list of films.

    DIR is a kit of `moireid lab generator-kit cut`. In its clips.csv, `outcome` says kept or discarded, `reason` why it
    was discarded, and `generator` what made the clip. Copy a line for a further clip. A clip that lost its markers
    needs `corners`: X,Y,... of the striped region, as `moireid lab evaluate` reads them.
    """
    from moireid_lab.evaluation.generator_kit import listed

    manifest, generators = listed(folder)
    if as_json:
        show_json({"manifest": str(manifest), "generators": [asdict(one) for one in generators]})
        return
    echo(f"{'generator':<24}{'made':>6}{'kept':>6}{'discarded':>11}")
    for one in generators:
        echo(f"{one.generator[:23]:<24}{one.made:>6}{one.kept:>6}{one.made - one.kept:>11}")
        for reason, count in one.discarded.items():
            echo(f"  {count} x {reason}")
    echo(f"score them with: moireid lab evaluate {manifest} --out scored")
